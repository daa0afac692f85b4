/// A camera's window onto the far field, in any position: which grid of frequencies to compute, and
/// how bright each pixel is.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_map.hpp"

namespace ovws::twin {

/// Where the camera stands along the grid (multiples of 90 degrees, mirrored or not) the grid has
/// the camera's own pixels. Else its step is half of what the SLM's size asks for (the far field of
/// W pixels is band-limited: 1 / W tells all of it), and each pixel is read between 12 x 12 points
/// through a Kaiser-windowed sinc: within 1e-4 of the field's peak. Immutable.
class CameraView {
 public:
  /// The grid never spans more than one period of the far field, 1 cycle per SLM pixel.
  CameraView(const CameraMap& map, const SlmGeometry& slm, const Roi& window);

  const FarFieldWindow& grid() const { return grid_; }

  /// The field at the pixels of rows [first_row, end_row), of a window's size. `far`: the field on
  /// the grid, phases about the SLM's centre. Its sign may be lost.
  void read(const Image<std::complex<float>>& far, int first_row, int end_row,
            Image<std::complex<float>>& out) const;

  static constexpr int kTaps = 12;

 private:
  void align(const CameraMap& map);
  void turn(const CameraMap& map, const SlmGeometry& slm);
  void copy(const Image<std::complex<float>>& far, int first_row, int end_row,
            Image<std::complex<float>>& out) const;

  int width_, height_;
  bool aligned_;
  FarFieldWindow grid_;
  /// Grid point of pixel (c, r): start_ + c per_column_ + r per_row_.
  Vec2 start_, per_column_, per_row_;
  std::array<int, 2> period_{};  ///< grid points in a period
  using Taps = std::array<float, kTaps>;
  std::vector<Taps> kernel_;  ///< for equal steps of the place between two points, both ends in it
};

}  // namespace ovws::twin
