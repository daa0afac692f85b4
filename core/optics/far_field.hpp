/// The far field of the SLM in the window that the camera sees.
#pragma once

#include <complex>
#include <memory>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// A window in the far field: its point (c, r) looks at the frequency origin + step * (c, r).
struct FarFieldWindow {
  int cols = 0;
  int rows = 0;
  Vec2 origin_cpp;          ///< cycles per SLM pixel at (0, 0)
  double step_cpp = 0.0;    ///< a camera's pixel: 1 / camera_px_per_cycle
  double step_y_cpp = 0.0;  ///< along y where it differs; 0: step_cpp
};

/// The window of an ROI-sized image whose base spot (frequency grooves / SLM size) falls on
/// base_spot_px.
FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows);

/// F(u, v) = sum A(x, y) exp(-2 pi i (u x + v y)), x and y from the pupil's centre, by the chirp-z
/// transform: any window, any step, no full-size FFT. Prepared once per geometry; `propagate` is
/// for one thread at a time.
class FarField {
 public:
  FarField(SlmGeometry slm, FarFieldWindow window);
  ~FarField();
  FarField(FarField&&) noexcept;
  FarField& operator=(FarField&&) noexcept;
  FarField(const FarField&) = delete;
  FarField& operator=(const FarField&) = delete;

  /// `field`: width x height of the SLM. Result: cols x rows of the window.
  void propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
