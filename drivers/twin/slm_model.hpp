/// Model of the twin's SLM and its illumination: from grey levels to the field behind the SLM.
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

/// True phase of a grey level, waves, not wrapped.
double slm_phase_waves(const SlmConfig& slm, int grey);

/// One thread at a time.
class SlmModel {
 public:
  explicit SlmModel(const Config& config);

  /// Sets the aberration of the light on the SLM, over the sensor's pupil (0 outside), and the
  /// shades in front of the SLM.
  void set_aberration(std::span<const Mode> modes, std::span<const Shade> shades = {});

  /// Sets the turbulence at this moment, which adds to the aberration; null: none.
  void set_turbulence(const Turbulence* turbulence, std::int64_t t_ns);

  /// Computes rows [first_row, end_row) of the field behind the SLM. `grey` and `field`: width x
  /// height of the SLM; amplitude 1 at the beam's centre. May be called in several threads at once,
  /// for different rows.
  void modulate(const Image<std::uint8_t>& grey, int first_row, int end_row,
                Image<std::complex<float>>& field) const;

  /// Amplitude of the beam, 1 at its centre.
  float amplitude(int x, int y) const { return amplitude_.width > 0 ? amplitude_.at(x, y) : 1.0F; }
  /// Flatness error at each pixel; empty: none.
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
