/// Pictures of steps: camera images and graphs, 8-bit grey.
#pragma once

#include <utility>
#include <vector>

#include "core/base/image.hpp"

namespace ovws::commission {

/// A camera image for people. `fractions`: of full scale. The brightest pixel becomes white, unless
/// it is darker than a twentieth of full scale.
Image<std::uint8_t> grey_of(const Image<float>& fractions);

/// A frame of black lines on white that encloses x from x_min to x_max, and y upwards.
class Graph {
 public:
  Graph(double x_min, double x_max, double y_min, double y_max);
  /// Draws straight lines between the points.
  void line(const std::vector<std::pair<double, double>>& points);
  void point(double x, double y);
  /// Draws a bar from 0 to y; `half_width` in units of x.
  void bar(double x, double half_width, double y);
  const Image<std::uint8_t>& image() const { return image_; }

 private:
  std::pair<double, double> at(double x, double y) const;
  void dot(int x, int y, std::uint8_t value);

  double x_min_, x_max_, y_min_, y_max_;
  Image<std::uint8_t> image_;
};

/// Draws a cross (black on bright ground, white on dark) at pixel (x, y).
void mark(Image<std::uint8_t>& image, double x, double y);

}  // namespace ovws::commission
