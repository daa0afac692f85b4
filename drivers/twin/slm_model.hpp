/// The twin's own SLM and the light on it: from grey levels to the field that leaves the SLM.
#pragma once

#include <array>
#include <complex>
#include <optional>
#include <span>

#include "core/base/image.hpp"
#include "core/optics/zernike.hpp"
#include "drivers/twin/pupil_screen.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// The phase that a grey level truly has, waves, its whole ones included.
double slm_phase_waves(const SlmConfig& slm, int grey);

/// One thread at a time.
class SlmModel {
 public:
  explicit SlmModel(const Config& config);

  /// The wavefront of the light that meets the SLM, over the sensor's pupil; 0 outside. And what
  /// stands in its way.
  void set_aberration(std::span<const Mode> modes, std::span<const Shade> shades = {});

  /// And what turbulence adds to it at this moment; null: none.
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns);

  /// `grey`: width x height of the SLM. `field`: as wide, and filled with the rows of the SLM from
  /// `first_row` on; amplitude 1 in the middle of the beam. May be called by several threads.
  void modulate(const Image<std::uint8_t>& grey, int first_row,
                Image<std::complex<float>>& field) const;

  /// Of the beam, 1 in its middle.
  float amplitude(int x, int y) const { return amplitude_.width > 0 ? amplitude_.at(x, y) : 1.0F; }
  /// The error of the surface at each pixel; empty: none.
  const Image<float>& surface_waves() const { return surface_waves_; }

 private:
  Config config_;
  std::array<std::complex<float>, 256> phasor_of_grey_;
  Image<float> surface_waves_;           ///< flatness error; empty: none
  Image<float> amplitude_;               ///< of the beam; empty: 1 everywhere
  Image<std::complex<float>> incident_;  ///< beam, aberration and surface
  std::optional<PupilScreen> screen_;    ///< turbulence
};

}  // namespace ovws::twin
