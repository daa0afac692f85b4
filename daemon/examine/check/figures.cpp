#include "daemon/examine/check/report.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/examine/check/measured.hpp"

namespace ovws::examine {
namespace {

using study::Figure;
using study::Series;

constexpr std::size_t kMostCurves = 5;
constexpr double kCrosstalkScale = 10.0;

Figure slopes(const Response& response) {
  Figure figure{"slopes", "0.1 wave of each mode, read back", "mode j", "read / shown", false,
                false};
  Series slope{"slope, with its standard error"}, ideal{"ideal"};
  slope.style = Series::Style::points;
  ideal.style = Series::Style::line;
  for (const Poke& poke : response.pokes) {
    if (!poke.read) continue;
    slope.add(poke.j, slope_of(poke, response.modes_j));
    ideal.add(poke.j, 1.0);
  }
  figure.series = {slope, ideal};
  return figure;
}

Figure noise(const Stability& stability) {
  Figure figure{"noise", "Standard error of a single frame", "mode j", "wave", false, true};
  Series measured{"measured"}, stated{"stated by the frames"}, spread{"spread over the record"};
  for (const ModeStability& mode : stability.modes) {
    measured.add(mode.j, mode.noise);
    if (!std::isnan(mode.stated)) stated.add(mode.j, mode.stated);
    spread.add(mode.j, mode.spread);
  }
  figure.series = {measured, spread};
  if (!stated.x.empty()) figure.series.push_back(stated);
  return figure;
}

/// Indices of the modes whose means of a second move most.
std::vector<std::size_t> liveliest(const Seconds& seconds) {
  std::vector<double> moves;
  for (const auto& values : seconds.waves) moves.push_back(study::mean_of(values).standard_error);
  std::vector<std::size_t> order(moves.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t k) { return moves[k]; });
  order.resize(std::min(order.size(), kMostCurves));
  return order;
}

Figure drift(const Record& record) {
  const Seconds seconds = seconds_of(record);
  Figure figure{"drift", "Means of a second, the modes that move most", "time, s", "wave"};
  for (const std::size_t k : liveliest(seconds)) {
    Series series{zernike_name(record.modes_j[k])};
    series.x = seconds.times_s;
    series.y = seconds.waves[k];
    figure.series.push_back(std::move(series));
  }
  return figure;
}

Figure allan(const Record& record) {
  const AllanCurve curve = allan_of(record);
  Figure figure{"allan",
                "How well a mean repeats (Allan deviation, all modes)",
                "averaged over, s",
                "wave",
                true,
                true};
  Series measured{"measured"}, white{"noise without drift"};
  white.style = Series::Style::line;
  for (std::size_t i = 0; i < curve.times_s.size(); ++i) {
    measured.add(curve.times_s[i], curve.waves[i]);
    white.add(curve.times_s[i],
              curve.waves.front() * std::sqrt(curve.times_s.front() / curve.times_s[i]));
  }
  figure.series = {measured, white};
  return figure;
}

Series rms_over_time(const char* name, const Record& record, double seconds) {
  Series series{name};
  series.style = Series::Style::solid;
  const double begin = record.frames.empty() ? 0.0 : record.frames.front().t_s;
  for (const Frame& frame : record.frames) {
    if (!frame.valid || frame.t_s - begin > seconds) continue;
    series.add(frame.t_s - begin, std::sqrt(square_waves(frame, record.modes_j)));
  }
  return series;
}

Figure loop(const Measured& measured) {
  Figure figure{"loop",    "Wavefront with the loop open and closed",
                "time, s", "wave RMS without tilts",
                false,     true};
  const double seconds = measured.loop.record.seconds();
  figure.series = {rms_over_time("open", measured.open, seconds),
                   rms_over_time("closed", measured.loop.record, seconds)};
  return figure;
}

std::string colour_of(double value) {
  const int fade = int(std::lround(255.0 * (1.0 - std::min(1.0, std::abs(value)))));
  return value >= 0.0 ? fmt::format("rgb({0},{0},255)", fade)
                      : fmt::format("rgb(255,{0},{0})", fade);
}

}  // namespace

std::vector<Figure> figures_of(const Measured& measured) {
  std::vector<Figure> figures;
  const auto read = std::ranges::count_if(measured.response.pokes, &Poke::read);
  if (read > 0) figures.push_back(slopes(measured.response));
  const Stability stability = stability_of(measured.open);
  if (stability.usable) {
    figures.push_back(noise(stability));
    figures.push_back(drift(measured.open));
    figures.push_back(allan(measured.open));
  }
  if (stability.usable && !measured.loop.loop.is_null()) figures.push_back(loop(measured));
  return figures;
}

std::string matrix_svg(const Response& response) {
  constexpr int kCell = 18, kMargin = 40;
  const int columns = int(response.pokes.size()), rows = int(response.modes_j.size());
  std::string svg = fmt::format(
      "<svg class=\"matrix\" role=\"img\" aria-label=\"response matrix\" viewBox=\"0 0 {} {}\" "
      "font-size=\"9\" font-family=\"sans-serif\">\n",
      kMargin + columns * kCell + 2, kMargin + rows * kCell + 2);
  svg += fmt::format(
      "<text x=\"{}\" y=\"10\">mode shown, j</text><text x=\"2\" y=\"{}\">read</text>\n", kMargin,
      kMargin - 4);
  for (int row = 0; row < rows; ++row) {
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>", kMargin - 4,
                       kMargin + row * kCell + 13, response.modes_j[std::size_t(row)]);
  }
  for (int column = 0; column < columns; ++column) {
    const Poke& poke = response.pokes[std::size_t(column)];
    const int x = kMargin + column * kCell;
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", x + kCell / 2,
                       kMargin - 4, poke.j);
    for (int row = 0; row < rows; ++row) {
      const int y = kMargin + row * kCell, read_j = response.modes_j[std::size_t(row)];
      const double gain = poke.read ? poke.gain[std::size_t(row)].value : 0.0;
      const double shown = read_j == poke.j ? gain : kCrosstalkScale * gain;
      svg += fmt::format(
          "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" stroke=\"#ccc\" "
          "stroke-width=\"0.5\"><title>j = {} shown, j = {} read: {}</title></rect>\n",
          x, y, kCell, kCell, poke.read ? colour_of(shown) : "#eee", poke.j, read_j,
          poke.read ? signed_decimals(gain, 4) : "not readable");
    }
  }
  return svg + "</svg>\n";
}

}  // namespace ovws::examine
