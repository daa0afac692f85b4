/// Fraunhofer propagation from the SLM to a window of the far field, such as the camera's.
#pragma once

#include <complex>
#include <memory>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// A sampled window of the far field: point (c, r) has the frequency origin + step * (c, r).
struct FarFieldWindow {
  int cols = 0;
  int rows = 0;
  Vec2 origin_cpp;          ///< cycles per SLM pixel at (0, 0)
  double step_cpp = 0.0;    ///< for one camera pixel: 1 / camera_px_per_cycle
  double step_y_cpp = 0.0;  ///< step along y, if it differs; 0: step_cpp
};

/// The window of a camera image of this size: the base grating's frequency (grooves / SLM size)
/// falls on base_spot_px.
FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows);

/// Far field by chirp-z transforms: F(u, v) = sum A(x, y) exp(-2 pi i (u x + v y)), x and y from
/// the pupil's centre. It allows any window and step and needs no zero-padded FFT. Prepared once
/// per geometry; `propagate` is for one thread at a time.
class FarField {
 public:
  /// `workers`: threads that may call transform_rows or transform_columns at once.
  FarField(SlmGeometry slm, FarFieldWindow window, int workers = 1);
  ~FarField();
  FarField(FarField&&) noexcept;
  FarField& operator=(FarField&&) noexcept;
  FarField(const FarField&) = delete;
  FarField& operator=(const FarField&) = delete;

  /// `field`: width x height of the SLM. Result: cols x rows of the window.
  void propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out);
  /// The two steps of `propagate` for parts of the images: first the SLM's rows [first, end) for
  /// all rows, then the window's columns. `worker`: 0 .. workers - 1. `out` has the window's size.
  void transform_rows(const Image<std::complex<float>>& field, int first, int end, int worker);
  void transform_columns(int first, int end, int worker, Image<std::complex<float>>& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
