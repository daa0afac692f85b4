/// Ground-truth judge: measures the true residual wavefront of the bench against the ideal
/// hologram.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/twin/ideal_hologram.hpp"
#include "drivers/twin/pupil_blocks.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Residual wavefront: the field behind the SLM times the conjugate of the ideal hologram. It
/// contains hidden aberration, turbulence, flatness error and the shown image through the twin's
/// SLM response. Evaluated inside the subapertures, or for the grating inside the pupil. Modes are
/// RMS-normalised waves.
struct Verdict {
  std::vector<Mode> modes;  ///< j = 0 .. 20 by least squares over that light
  double rms_waves = 0.0;  ///< RMS without piston and tilts, including what is finer than the modes
  double rms_with_tilt_waves = 0.0;  ///< RMS without piston
  /// Strehl ratio |sum A exp(i phi)|^2 / (sum A)^2 of the first order, without and with the tilts j
  /// = 1, 2.
  double strehl = 0.0;
  double strehl_with_tilt = 0.0;
  /// Diffraction efficiency of the first order: |mean field|^2 with all modes removed. Wavefront
  /// errors finer than the modes lower it, too.
  double first_order = 0.0;
};

/// One thread at a time. A verdict takes 100 to 300 ms, the first one of each pattern longer.
class Judge {
 public:
  explicit Judge(const Config& config);

  /// Judges the grey levels shown on the SLM. None if the phase could not be unwrapped.
  /// `turbulence`: null for none.
  std::optional<Verdict> judge(Pattern pattern, const Image<std::uint8_t>& grey,
                               const std::vector<Mode>& aberration, const Turbulence* turbulence,
                               std::int64_t t_ns);
  /// Flatness error of the SLM: modes j = 0 .. 20 by least squares over the light in the pupil;
  /// none if the phase could not be unwrapped.
  std::optional<std::vector<Mode>> flatness_modes();
  /// True phase of each grey level, waves.
  static std::array<double, 256> lut_waves(const SlmConfig& slm);

 private:
  struct Expected {
    Image<std::complex<float>> ideal;
    PupilBlocks blocks;
  };
  const Expected& expected(Pattern pattern);

  const Config config_;
  SlmModel slm_;
  std::vector<Mode> aberration_;
  std::array<std::unique_ptr<Expected>, 2> expected_;  ///< by pattern, created on first use
};

}  // namespace ovws::twin
