/// Diffraction model of the sensor for an incoming wavefront: complex field on the SLM and in the
/// camera's window.
#pragma once

#include <array>
#include <complex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/pupil_cells.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

/// Differs from SensorModel in five ways: the camera may be turned or mirrored; the field is summed
/// in cells of some SLM pixels (PupilCells), which makes it three times as fast and wrong by 0.2 %
/// of a spot's peak field RMS; the wavefront is not rounded to 8 bits, each subaperture may have
/// its own light, and stray light from outside the subapertures can be excluded. For one thread
/// at a time.
class SensorField {
 public:
  /// A polynomial over a subaperture: coefficients of xi^a eta^b by rising a, then b, a + b <= 3,
  /// where (xi, eta) is the position from its centre in units of its radius.
  using LocalField = std::array<std::complex<double>, 10>;

  /// Errors as of HologramRenderer::make. `cols` x `rows`: the camera's image.
  static Result<SensorField> make(const SensorConfig& sensor, const SlmGeometry& slm,
                                  const OpticsConfig& optics, int cols, int rows);

  /// Along the camera's axes.
  const FarFieldWindow& window() const { return window_; }
  const PupilCells& cells() const { return cells_; }
  int subapertures() const { return cells_.subapertures; }

  /// Whether propagate() includes the light outside the subapertures; by default it does.
  void set_outside(bool lit) { outside_lit_ = lit; }
  bool outside() const { return outside_lit_; }
  /// What the light does besides the modes; empty: nothing.
  struct Light {
    std::span<const Vec2> slopes_cpp{};    ///< of the phase over each subaperture
    std::span<const LocalField> fields{};  ///< added to 1, times the field of each subaperture
    std::span<const Mode> ln_amplitude{};  ///< of the light outside the subapertures
  };
  /// Computes pupil() and far(), some 7 ms for the default bench. Requires finite modes of valid
  /// index.
  void propagate(std::span<const Mode> modes, const Light& light);

  /// The field in the cells of cells().runs of the last propagate(); without the light outside,
  /// those of the subapertures only.
  std::span<const std::complex<float>> pupil() const { return pupil_; }
  /// The far field in the window, see FarField.
  const Image<std::complex<float>>& far() const { return far_; }

 private:
  SensorField(FarFieldWindow window, PupilCells cells);
  void set_phasors(std::span<const Mode> modes);
  void multiply(const CellRun& run, const LocalField& field);
  void add_run(const CellRun& run, const Light& light);
  const Image<std::complex<float>>& far_outside_pupil(std::span<const Mode> ln_amplitude);

  FarFieldWindow window_;
  PupilCells cells_;
  bool outside_lit_ = true;
  FarField far_field_;                  ///< of sums_
  Image<std::complex<float>> phasors_;  ///< what modes make of a cell
  std::vector<std::complex<float>> pupil_;
  Image<std::complex<float>> sums_;                      ///< of pupil_ over the pieces
  std::optional<std::vector<Mode>> fixed_ln_amplitude_;  ///< for which fixed_ was computed
  Image<std::complex<float>> fixed_;                     ///< far field of light outside the pupil
  Image<std::complex<float>> far_;
};

}  // namespace ovws
