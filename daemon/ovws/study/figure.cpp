#include "daemon/ovws/study/figure.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace ovws::study {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string csv_of(const Figure& figure) {
  std::string text = "series,x,y,error\n";
  for (const Series& series : figure.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      text += fmt::format("{},{:.8g},{:.8g},", quoted(series.name), series.x[i], series.y[i]);
      if (!series.error.empty()) text += fmt::format("{:.8g}", series.error[i]);
      text += "\n";
    }
  }
  return text;
}

/// gnuplot colour of the k-th series. Lines (bounds) are black unless `colour` names a series.
std::string colour_of(const Series& series, std::size_t k) {
  if (series.colour > 0) return std::to_string(series.colour);
  const bool black = series.colour == Series::kBlack || series.style == Series::Style::line;
  return black ? "'black'" : std::to_string(k + 1);
}

/// gnuplot style of the k-th series.
std::string style_of(const Series& series, std::size_t k) {
  const std::string colour = colour_of(series, k);
  if (series.style == Series::Style::line) {
    return fmt::format("lines linecolor {} dashtype {}", colour, series.colour > 0 ? 2 : k % 4 + 2);
  }
  if (series.style == Series::Style::solid) return fmt::format("lines linecolor {}", colour);
  const char* kind = series.style == Series::Style::points ? "points" : "linespoints";
  return fmt::format("{} linecolor {} pointtype {}", kind, colour, k + 4);
}

/// The largest 1, 2 or 5 times a power of ten that is at most `value`.
double round_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double digit = value / power;
  return power * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0);
}

/// gnuplot settings of a logarithmic axis. Ranges of two decades or less get tics at 1, 2 and 5.
/// The y range ends at round numbers, the x range just beyond the data.
std::string log_axis(char axis, std::vector<double> values) {
  std::erase_if(values, [](double value) { return !(value > 0.0 && std::isfinite(value)); });
  std::string text = fmt::format("set logscale {0}\nset format {0} '%g'\n", axis);
  if (values.empty()) return text;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double from = round_below(*least), to = 1.0 / round_below(1.0 / *most);
  text += axis == 'x' ? fmt::format("set xrange [{:.6g}:{:.6g}]\n", *least / 1.1, *most * 1.1)
                      : fmt::format("set yrange [{:.6g}:{:.6g}]\n", from, to);
  if (to > 100.0 * from) return text;
  std::string tics;
  for (double tic = from; tic < 1.001 * to; tic = 1.0 / round_below(0.9 / tic)) {
    tics += fmt::format("{}{:.6g}", tics.empty() ? "" : ", ", tic);
  }
  return text + fmt::format("set {}tics ({})\n", axis, tics);
}

std::string axes_of(const Figure& figure) {
  std::vector<double> x, y;
  for (const Series& series : figure.series) {
    x.insert(x.end(), series.x.begin(), series.x.end());
    y.insert(y.end(), series.y.begin(), series.y.end());
  }
  std::string text;
  if (figure.log_x) text += log_axis('x', std::move(x));
  if (figure.log_y) text += log_axis('y', std::move(y));
  if (figure.same_scale) text += "set size ratio -1\n";
  if (!std::isnan(figure.y_from)) text += fmt::format("set yrange [{}:]\n", figure.y_from);
  if (!std::isnan(figure.y_to)) text += fmt::format("set yrange [:{}]\n", figure.y_to);
  if (!std::isnan(figure.x_step)) text += fmt::format("set xtics {}\n", figure.x_step);
  return text;
}

/// Data lines of a series; an empty line makes a gap for a missing value.
std::string data_of(const Series& series) {
  std::string text;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double error = series.error.empty() ? 0.0 : series.error[i];
    text += std::isfinite(series.y[i])
                ? fmt::format("{:.8g} {:.8g} {:.8g}\n", series.x[i] + series.shift_x, series.y[i],
                              error)
                : std::string("\n");
  }
  return text;
}

bool can_be_drawn(const Series& series) {
  return std::any_of(series.y.begin(), series.y.end(), [](double y) { return std::isfinite(y); });
}

/// Terminal and output of a PNG file in the current folder.
std::string png_terminal(const Figure& figure) {
  return fmt::format(
      "set terminal pngcairo size 1200,900 font 'sans,16' linewidth 1.8\nset output {}\n",
      quoted(figure.name + ".png"));
}

/// The gnuplot script: one data block per series, then the plot command. `terminal`: commands that
/// set terminal and output.
std::string script_of(const Figure& figure, std::string terminal) {
  std::string text =
      std::move(terminal) +
      fmt::format(
          "set title {} noenhanced\nset xlabel {} offset 0,0.4 noenhanced\nset ylabel "
          "{} noenhanced\n"
          "set offsets graph 0.02, graph 0.02, 0, 0\nset grid\nset key below height 1 maxcols 3 "
          "noenhanced font ',13'\nset pointsize 1.4\n"
          "set linetype 5 linecolor rgb '#8c6d1f'\nset linetype 8 linecolor rgb '#666666'\n"
          "set linetype 9 linecolor rgb '#e377c2'\nset linetype 10 linecolor rgb '#17becf'\n",
          quoted(figure.title), quoted(figure.x_label), quoted(figure.y_label));
  text += axes_of(figure);
  std::string plots;
  for (std::size_t k = 0; k < figure.series.size(); ++k) {
    const Series& series = figure.series[k];
    if (!can_be_drawn(series)) continue;
    text += fmt::format("$data{} << EOD\n{}EOD\n", k, data_of(series));
    plots +=
        fmt::format("{}$data{} with {} {}", plots.empty() ? "plot " : ", ", k, style_of(series, k),
                    series.in_legend ? "title " + quoted(series.name) : "notitle");
    if (!series.error.empty()) {
      plots += fmt::format(
          ", $data{} using 1:($2-$3):(0):(2*$3) with vectors nohead linecolor {} notitle", k,
          colour_of(series, k));
    }
  }
  return text + plots + "\n";
}

/// Errors: gnuplot is missing or fails.
Result<void> run_gnuplot(const std::string& script) {
  if (std::system("command -v gnuplot > /dev/null") != 0) {
    return fail(Errc::unavailable, "", "gnuplot is missing (package gnuplot-nox)");
  }
  std::FILE* gnuplot = ::popen("gnuplot", "w");
  if (gnuplot == nullptr) return fail(Errc::unavailable, "", "gnuplot cannot be started");
  const bool sent = std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
  if (::pclose(gnuplot) != 0 || !sent) return fail(Errc::unavailable, "", "gnuplot failed");
  return {};
}

}  // namespace

Result<void> write_text(const std::string& text, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (file) return {};
  return fail(Errc::unavailable, "output", path.string() + " cannot be written");
}

Result<void> write_numbers(const Figure& figure, const std::filesystem::path& folder) {
  if (auto done = write_text(csv_of(figure), folder / (figure.name + ".csv")); !done) return done;
  return write_text(script_of(figure, png_terminal(figure)), folder / (figure.name + ".gnuplot"));
}

Result<void> draw(const Figure& figure, const std::filesystem::path& folder) {
  const std::string script =
      fmt::format("cd {}\nload {}\n", quoted(folder.string()), quoted(figure.name + ".gnuplot"));
  auto drawn = run_gnuplot(script);
  if (drawn) return {};
  return fail(Errc::unavailable, "",
              fmt::format("{}: {}: the numbers are in {}; draw the figures with: cd {} && gnuplot "
                          "*.gnuplot",
                          figure.name, drawn.error().reason, folder.string(), folder.string()));
}

Result<std::string> svg_of(const Figure& figure) {
  std::string name = std::filesystem::temp_directory_path() / "ovws-figure-XXXXXX";
  const int file = ::mkstemp(name.data());
  if (file < 0) return fail(Errc::unavailable, "", name + " cannot be created");
  ::close(file);
  const std::string path = name;
  const std::string terminal = fmt::format(
      "set terminal svg size 760,460 dynamic font 'sans,14' linewidth 1.5 name {} background "
      "'white'\nset output {}\n",
      quoted(figure.name), quoted(path));
  auto drawn = run_gnuplot(script_of(figure, terminal) + "unset output\n");
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  if (!drawn) return fail(drawn.error());
  const std::size_t begin = text.str().find("<svg");  // after the declarations of an XML file
  if (begin != std::string::npos) return text.str().substr(begin);
  return fail(Errc::unavailable, "", "gnuplot has no SVG terminal");
}

}  // namespace ovws::study
