/// Optical model of the bench with a fixed lenslet array.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/twin/lenslet_fields.hpp"
#include "drivers/twin/optical_model.hpp"
#include "drivers/twin/phase_grid.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Light falls on a lenslet array, and the camera is in the focal plane of the lenslets. There is
/// no SLM, so grey levels have no effect. Beyond its pupil the aberration continues as a
/// polynomial. A change of the wavefront takes some 40 us for each lenslet in the window; a change
/// of the window, geometry or amplitude some 100 us for each lenslet.
class ArrayModel : public OpticalModel {
 public:
  explicit ArrayModel(const Config& config);

  void set_light(const Light& light) override;
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns) override;
  void set_window(const Roi& window, const CameraGeometry& geometry) override;
  Image<float> intensity(const Image<std::uint8_t>& grey) override;
  void prepare(const Image<std::uint8_t>&) override {}

  /// Of the lenslets that get at least half of the beam's light, row by row.
  std::vector<Vec2> true_spots_px(const Truth& truth) const override;
  double photons_per_peak_photon(const CameraGeometry& geometry) const override;
  std::unique_ptr<Judge> make_judge() const override { return nullptr; }

  /// Map from the array's plane, micrometres from the array's centre, to sensor pixels.
  CameraMap map(const CameraGeometry& geometry) const;

 private:
  float beam_amplitude(Vec2 at_um) const;
  /// Light on the array without what is smooth: aberration, mirror, turbulence and scintillation.
  std::complex<float> incident(Vec2 at_um) const;
  PupilLine pupil_line() const;  ///< of the grid, along x or y
  Eigen::MatrixXf sample(const std::vector<Mode>& modes) const;

  const Config config_;
  const PhaseGrid grid_;
  Light light_;
  std::optional<Roi> window_;
  CameraGeometry geometry_;
  std::optional<DeformableMirror> mirror_;
  Eigen::MatrixXf aberration_waves_;
  Eigen::MatrixXf mirror_waves_;         ///< empty: no mirror
  Eigen::MatrixXf turbulence_waves_;     ///< empty: none
  std::optional<LensletFields> fields_;  ///< none: amplitude, window or geometry have changed
};

}  // namespace ovws::twin
