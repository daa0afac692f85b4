/// Draws the coefficients as signed bars.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovws/screen/page.hpp"
#include "daemon/ovws/text/mode_names.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;

constexpr double kMinScaleWaves = 0.1;
constexpr int kNumberWidth = 9, kIndexWidth = 4, kMinBarWidth = 11;

/// Draws a bar from the middle to the right (positive) or left, in steps of half a character.
void draw_bar(Canvas& canvas, int x, int y, int width, double waves, double scale_waves) {
  const int half = (width - 1) / 2;
  const int middle = x + half;
  const int halves = std::min(2 * half, int(std::lround(std::abs(waves) / scale_waves * 2 * half)));
  const Style style = waves < 0 ? Style::negative : Style::positive;
  const int step = waves < 0 ? -1 : 1;
  canvas.put(middle, y, U'│', Style::dim);
  for (int k = 1; k <= halves / 2; ++k) canvas.put(middle + step * k, y, U'█', style);
  if (halves % 2 != 0) {
    canvas.put(middle + step * (halves / 2 + 1), y, waves < 0 ? U'▐' : U'▌', style);
  }
}

double largest(const json& values) {
  double most = 0.0;
  for (const json& value : values) {
    if (value.is_number()) most = std::max(most, std::abs(value.get<double>()));
  }
  return most;
}

/// Standard error of all modes together, root sum square; empty if positions measured the frame.
std::string error_of(const json& wavefront) {
  double squares = 0.0;
  const json sigma = wavefront.value("sigma", json::array());
  for (const json& value : sigma) {
    if (!value.is_number()) return "";
    squares += value.get<double>() * value.get<double>();
  }
  return sigma.empty() ? "" : fmt::format(" ±{:.4f}", std::sqrt(squares));
}

}  // namespace

double bar_scale_waves(double largest_waves) {
  double scale = kMinScaleWaves;
  for (const double step : {2.0, 2.5, 2.0}) {
    if (scale >= largest_waves) return scale;
    scale *= step;
  }
  return scale >= largest_waves ? scale : 10.0 * bar_scale_waves(largest_waves / 10.0);
}

void draw_modes(Canvas& canvas, Rect rect, const View& view, int& first_mode) {
  if (view.wavefront.is_null()) {
    canvas.text(rect.x, rect.y, rect.width, "modes", Style::title);
    return;
  }
  const json& modes = view.wavefront.at("j");
  const json& values = view.wavefront.at("coefficients");
  const int count = int(modes.size());
  const int rows = std::max(rect.height - 1, 0);
  first_mode = std::clamp(first_mode, 0, std::max(count - rows, 0));
  const double scale_waves = bar_scale_waves(largest(values));
  canvas.text(
      rect.x, rect.y, rect.width,
      fmt::format("modes {}-{} of {}{}, waves; bar ±{:g}", first_mode + 1,
                  std::min(first_mode + rows, count), count, error_of(view.wavefront), scale_waves),
      Style::title);
  const int name_width = std::min(int(cli::longest_name(modes)),
                                  rect.width - kIndexWidth - kNumberWidth - kMinBarWidth);
  for (int row = 0; row < rows && first_mode + row < count; ++row) {
    const auto k = std::size_t(first_mode + row);
    const int y = rect.y + 1 + row;
    const int j = modes.at(k).get<int>();
    canvas.text(rect.x, y, kIndexWidth, fmt::format("{:>3}", j), Style::dim);
    canvas.text(rect.x + kIndexWidth, y, name_width, zernike_name(j));
    const int x = rect.x + kIndexWidth + name_width;
    const bool has_value = values.at(k).is_number();
    const std::string number =
        fmt::format("{:>9}", has_value ? signed_decimals(values.at(k).get<double>(), 4) : "-");
    canvas.text(x, y, kNumberWidth, number);
    if (has_value) {
      draw_bar(canvas, x + kNumberWidth + 1, y, rect.x + rect.width - x - kNumberWidth - 1,
               values.at(k).get<double>(), scale_waves);
    }
  }
}

}  // namespace ovws::screen
