/// Sampling of the far field by a camera of any orientation: the frequency grid to compute, and its
/// interpolation at the pixels.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_map.hpp"

namespace ovws::twin {

/// If the camera is aligned with the grid (rotated by multiples of 90 degrees, mirrored or not),
/// the grid points are its pixels. Else the field is oversampled twice (it is band-limited: for W
/// SLM pixels a step of 1 / W is critical sampling), and each pixel is interpolated from 12 x 12
/// points by a Kaiser-windowed sinc, within 1e-4 of the field's peak. Immutable.
class CameraView {
 public:
  /// The grid never spans more than one period of the far field, 1 cycle per SLM pixel.
  CameraView(const CameraMap& map, const SlmGeometry& slm, const Roi& window);

  const FarFieldWindow& grid() const { return grid_; }

  /// Interpolates the field at the pixels of rows [first_row, end_row). `far`: the field on the
  /// grid, with phases relative to the SLM's centre. `out` has the window's size; its sign may be
  /// lost.
  void read(const Image<std::complex<float>>& far, int first_row, int end_row,
            Image<std::complex<float>>& out) const;

  static constexpr int kTaps = 12;

 private:
  void use_pixel_grid(const CameraMap& map);
  void use_oversampled_grid(const CameraMap& map, const SlmGeometry& slm);
  void copy(const Image<std::complex<float>>& far, int first_row, int end_row,
            Image<std::complex<float>>& out) const;

  int width_, height_;
  bool aligned_;
  FarFieldWindow grid_;
  /// Grid point of pixel (c, r): start_ + c per_column_ + r per_row_.
  Vec2 start_, per_column_, per_row_;
  std::array<int, 2> period_{};  ///< grid points in a period
  using Taps = std::array<float, kTaps>;
  std::vector<Taps>
      kernel_;  ///< weights for equal steps from one grid point to the next, inclusive
};

}  // namespace ovws::twin
