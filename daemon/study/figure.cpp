#include "daemon/study/figure.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <cstdio>
#include <fstream>

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

/// How gnuplot is to draw the k-th series; bounds and other lines are black.
std::string style_of(const Series& series, std::size_t k) {
  switch (series.style) {
    case Series::Style::line_points:
      return fmt::format("linespoints linecolor {} pointtype {}", k + 1, k + 4);
    case Series::Style::line:
      return fmt::format("lines linecolor 'black' dashtype {}", k % 4 + 2);
    case Series::Style::points:
      break;
  }
  return fmt::format("points linecolor {} pointtype {}", k + 1, k + 4);
}

Result<void> write_csv(const Figure& figure, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << "series,x,y,error\n";
  for (const Series& series : figure.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      file << fmt::format("{},{:.8g},{:.8g},", quoted(series.name), series.x[i], series.y[i]);
      if (!series.error.empty()) file << fmt::format("{:.8g}", series.error[i]);
      file << "\n";
    }
  }
  file.close();
  if (file) return {};
  return fail(Errc::unavailable, "output", path.string() + " cannot be written");
}

/// The data of each series as one block in the script, then how to draw them.
std::string script_of(const Figure& figure, const std::filesystem::path& png) {
  std::string text = fmt::format(
      "set terminal pngcairo size 1200,900 font 'sans,16' linewidth 1.8\n"
      "set output {}\nset title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n"
      "set grid\nset key below maxcols 3 noenhanced font ',13'\nset pointsize 1.4\n"
      "set linetype 5 linecolor rgb '#8c6d1f'\nset linetype 8 linecolor rgb '#666666'\n"
      "set linetype 9 linecolor rgb '#e377c2'\nset linetype 10 linecolor rgb '#17becf'\n",
      quoted(png.string()), quoted(figure.title), quoted(figure.x_label), quoted(figure.y_label));
  if (figure.log_x) text += "set logscale x\n";
  if (figure.log_y) text += "set logscale y\nset format y '%.0e'\n";
  if (figure.same_scale) text += "set size ratio -1\n";
  std::string plots;
  for (std::size_t k = 0; k < figure.series.size(); ++k) {
    const Series& series = figure.series[k];
    text += fmt::format("$data{} << EOD\n", k);
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const double error = series.error.empty() ? 0.0 : series.error[i];
      if (std::isfinite(series.y[i])) {
        text += fmt::format("{:.8g} {:.8g} {:.8g}\n", series.x[i], series.y[i], error);
      }
    }
    text += "EOD\n";
    plots += fmt::format("{}$data{} with {} title {}", plots.empty() ? "plot " : ", ", k,
                         style_of(series, k), quoted(series.name));
    if (!series.error.empty()) {
      plots += fmt::format(
          ", $data{} using 1:($2-$3):(0):(2*$3) with vectors nohead linecolor {} notitle", k,
          k + 1);
    }
  }
  return text + plots + "\n";
}

}  // namespace

Result<void> write_figure(const Figure& figure, const std::filesystem::path& folder) {
  const auto stem = folder / figure.name;
  if (auto done = write_csv(figure, stem.string() + ".csv"); !done) return done;
  std::FILE* gnuplot = ::popen("gnuplot", "w");
  if (gnuplot == nullptr) return fail(Errc::unavailable, "", "gnuplot cannot be started");
  const std::string script = script_of(figure, stem.string() + ".png");
  const bool sent = std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
  if (::pclose(gnuplot) != 0 || !sent) {
    return fail(
        Errc::unavailable, "",
        "gnuplot failed (package gnuplot-nox): the numbers are in " + stem.string() + ".csv");
  }
  return {};
}

}  // namespace ovws::study
