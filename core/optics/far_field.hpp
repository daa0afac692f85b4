/// Fraunhofer propagation from the SLM to a window of the far field, such as the camera's.
#pragma once

#include <complex>
#include <memory>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// Sampled window of the far field: column c, row r has the spatial frequency origin + step (c, r).
struct FarFieldWindow {
  int cols = 0;
  int rows = 0;
  Vec2 origin_cpp;          ///< cycles per SLM pixel at (0, 0)
  double step_cpp = 0.0;    ///< per camera pixel: 1 / camera_px_per_cycle
  double step_y_cpp = 0.0;  ///< step along y, if it differs; 0: step_cpp
};

/// Far-field window that matches a camera image of image_cols x image_rows pixels. The frequency of
/// the base grating (grooves / SLM size) falls on base_spot_px.
FarFieldWindow far_field_window(const SensorConfig& sensor, const SlmGeometry& slm,
                                const OpticsConfig& optics, int image_cols, int image_rows);

/// Far field by chirp-z transforms: F(u, v) = sum A(x, y) exp(-2 pi i (u x + v y)), x and y from
/// the pupil's centre. Chirp-z allows any window and step without a zero-padded FFT. Construct once
/// per geometry. Call `propagate` from one thread at a time.
class FarField {
 public:
  /// `workers`: number of threads that may call transform_rows or transform_columns at once.
  FarField(SlmGeometry slm, FarFieldWindow window, int workers = 1);
  ~FarField();
  FarField(FarField&&) noexcept;
  FarField& operator=(FarField&&) noexcept;
  FarField(const FarField&) = delete;
  FarField& operator=(const FarField&) = delete;

  /// Computes the far field `out` (cols x rows of the window) of `field` (size of the SLM).
  void propagate(const Image<std::complex<float>>& field, Image<std::complex<float>>& out);
  /// The two passes of `propagate`, split for several threads. First call transform_rows until all
  /// SLM rows are done, then transform_columns for the window's columns [first, end). `worker`:
  /// 0 .. workers - 1, one per thread. `out` must have the window's size.
  void transform_rows(const Image<std::complex<float>>& field, int first, int end, int worker);
  void transform_columns(int first, int end, int worker, Image<std::complex<float>>& out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
