#include "daemon/examine/commission/drawing.hpp"

#include <algorithm>
#include <cmath>

namespace ovws::commission {
namespace {

constexpr int kWidth = 480, kHeight = 320, kMargin = 12;
constexpr float kDarkest = 0.05F;
constexpr std::uint8_t kPaper = 255, kInk = 0, kRule = 200, kFill = 120;
constexpr int kCrossReach = 7, kCrossGap = 2;

}  // namespace

Image<std::uint8_t> grey_of(const Image<float>& fractions) {
  Image<std::uint8_t> grey(fractions.width, fractions.height);
  if (fractions.pixels.empty()) return grey;
  const float white = std::max(kDarkest, *std::ranges::max_element(fractions.pixels));
  std::ranges::transform(fractions.pixels, grey.pixels.begin(), [white](float value) {
    return std::uint8_t(std::lround(255.0F * std::clamp(value / white, 0.0F, 1.0F)));
  });
  return grey;
}

Graph::Graph(double x_min, double x_max, double y_min, double y_max)
    : x_min_(x_min),
      x_max_(x_max),
      y_min_(y_min),
      y_max_(y_max > y_min ? y_max : y_min + 1.0),
      image_(kWidth, kHeight, kPaper) {
  for (int k = 0; k <= 4; ++k) {  // a grid of four by four
    const int x = kMargin + k * (kWidth - 2 * kMargin) / 4;
    const int y = kMargin + k * (kHeight - 2 * kMargin) / 4;
    for (int i = kMargin; i <= kHeight - kMargin; ++i) dot(x, i, kRule);
    for (int i = kMargin; i <= kWidth - kMargin; ++i) dot(i, y, kRule);
  }
  if (y_min_ < 0.0 && y_max_ > 0.0) line({{x_min_, 0.0}, {x_max_, 0.0}});
}

std::pair<double, double> Graph::at(double x, double y) const {
  return {kMargin + (x - x_min_) / (x_max_ - x_min_) * (kWidth - 2 * kMargin),
          kHeight - kMargin - (y - y_min_) / (y_max_ - y_min_) * (kHeight - 2 * kMargin)};
}

void Graph::dot(int x, int y, std::uint8_t value) {
  if (x >= 0 && y >= 0 && x < image_.width && y < image_.height) image_.at(x, y) = value;
}

void Graph::line(const std::vector<std::pair<double, double>>& points) {
  for (std::size_t k = 1; k < points.size(); ++k) {
    const auto [x0, y0] = at(points[k - 1].first, points[k - 1].second);
    const auto [x1, y1] = at(points[k].first, points[k].second);
    const double longest = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
    const int count = int(std::ceil(std::min(longest, 2.0 * (kWidth + kHeight)))) + 1;
    for (int i = 0; i <= count; ++i) {
      const double part = double(i) / count;
      dot(int(std::lround(x0 + part * (x1 - x0))), int(std::lround(y0 + part * (y1 - y0))), kInk);
    }
  }
}

void Graph::point(double x, double y) {
  const auto [px, py] = at(x, y);
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      dot(int(std::lround(px)) + dx, int(std::lround(py)) + dy, kInk);
    }
  }
}

void Graph::bar(double x, double half_width, double y) {
  const auto [left, zero] = at(x - half_width, std::clamp(0.0, y_min_, y_max_));
  const auto [right, end] = at(x + half_width, std::clamp(y, y_min_, y_max_));
  for (int py = int(std::lround(std::min(zero, end))); py <= int(std::lround(std::max(zero, end)));
       ++py) {
    for (int px = int(std::lround(left)); px <= int(std::lround(right)); ++px) dot(px, py, kFill);
  }
}

void mark(Image<std::uint8_t>& image, double x, double y) {
  const int cx = int(std::lround(x)), cy = int(std::lround(y));
  for (int k = -kCrossReach; k <= kCrossReach; ++k) {
    if (std::abs(k) < kCrossGap) continue;
    for (const auto& [px, py] : {std::pair{cx + k, cy}, std::pair{cx, cy + k}}) {
      if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
      std::uint8_t& pixel = image.at(px, py);
      pixel = pixel > 127 ? 0 : 255;
    }
  }
}

}  // namespace ovws::commission
