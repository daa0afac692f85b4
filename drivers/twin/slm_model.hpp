/// Model of the twin's SLM and its illumination: from grey levels to the field behind the SLM.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/zernike.hpp"
#include "drivers/twin/turbulence.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// True phase of a grey level, in waves, not wrapped.
double slm_phase_waves(const SlmConfig& slm, int grey);

/// SLM and illumination. Use it in one thread at a time, except for `modulate`.
class SlmModel {
 public:
  explicit SlmModel(const Config& config);

  /// Sets the aberration of the light on the SLM and the shades in front of it. The aberration acts
  /// inside the sensor's pupil and is 0 outside.
  void set_aberration(std::span<const Mode> modes, std::span<const Shade> shades = {},
                      std::span<const LightVortex> branch_points = {});

  /// Sets the turbulence at time `t_ns` (UTC), which is added to the aberration; null: none.
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns);

  /// Computes rows [first_row, end_row) of the field behind the SLM, with amplitude 1 at the beam's
  /// centre. `grey` and `field` have the size of the SLM. Several threads may call this at once for
  /// different rows.
  void modulate(const Image<std::uint8_t>& grey, int first_row, int end_row,
                Image<std::complex<float>>& field) const;

  /// Field of the light, with the SLM's flatness error; without turbulence.
  const Image<std::complex<float>>& incident() const { return incident_; }
  using GreyPhasors = std::array<std::complex<float>, 256>;
  /// Factors on the light by the SLM's grey levels.
  const GreyPhasors& phasor_of_grey() const { return phasor_of_grey_; }
  /// Amplitude of the illuminating beam at an SLM pixel; 1 at the beam's centre.
  float amplitude(int x, int y) const { return amplitude_.width > 0 ? amplitude_.at(x, y) : 1.0F; }
  /// Flatness error of the SLM at each pixel, waves; empty if there is none.
  const Image<float>& surface_waves() const { return surface_waves_; }

 private:
  Config config_;
  GreyPhasors phasor_of_grey_;
  Image<float> surface_waves_;           ///< flatness error; empty: none
  Image<float> amplitude_;               ///< beam amplitude; empty: 1 everywhere
  Image<std::complex<float>> incident_;  ///< field of beam, aberration, shades and flatness error
  Eigen::MatrixXf turbulence_waves_;     ///< in the pupil's square, indices (x, y); empty: none
  int turbulence_x_px_ = 0, turbulence_y_px_ = 0;  ///< pixel of its element (0, 0)
};

}  // namespace ovws::twin
