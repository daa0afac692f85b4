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
#include "drivers/twin/tap_sum.hpp"

namespace ovws::twin {

/// Far-field sampling at the camera's pixels. If the camera is rotated by a multiple of 90 degrees,
/// mirrored or not, the grid points are the pixels. Else the field is oversampled twice; critical
/// sampling is a step of 1 / W cycles for W SLM pixels. A Kaiser-windowed sinc then interpolates
/// each pixel from 12 x 12 grid points, within 1e-4 of the field's peak. Immutable.
class CameraView {
 public:
  /// Chooses the grid. An oversampled grid spans at most one period of the far field (1 cycle per
  /// SLM pixel) plus the interpolation margin.
  CameraView(const CameraMap& map, const SlmGeometry& slm, const Roi& window);

  const FarFieldWindow& grid() const { return grid_; }
  bool aligned() const { return aligned_; }  ///< the grid points are the pixels

  /// Interpolates the field at the pixels of a row of the window. `far`: the field on the grid,
  /// with phases relative to the SLM's centre. The sign of the field may be inverted.
  void read(const Image<std::complex<float>>& far, int row, std::complex<float>* out) const;

  static constexpr int kTaps = kTapsAcross;

 private:
  void use_pixel_grid(const CameraMap& map);
  void use_oversampled_grid(const CameraMap& map, const SlmGeometry& slm);
  void copy(const Image<std::complex<float>>& far, int row, std::complex<float>* out) const;

  int width_, height_;
  bool aligned_;
  FarFieldWindow grid_;
  /// Grid point of pixel (c, r): start_ + c per_column_ + r per_row_.
  Vec2 start_, per_column_, per_row_;
  std::array<int, 2> period_{};  ///< grid points per period of the far field, along x and y
  using Taps = std::array<float, kTaps>;
  std::vector<Taps>
      kernel_;  ///< weights at equal steps from one grid point to the next, including both ends
};

}  // namespace ovws::twin
