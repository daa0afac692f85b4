/// Ground-truth judge: computes the wavefront by which the light behind the twin's SLM differs from
/// that of an ideal SLM (the true residual).
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

/// Residual wavefront: phase of the field behind the SLM times the conjugate of the ideal hologram.
/// It contains the hidden aberration, turbulence, flatness error and the shown image through the
/// twin's SLM response. Evaluated inside the subapertures (Pattern::grating: inside the pupil).
/// Modes are in RMS-normalised waves.
struct Verdict {
  std::vector<Mode> modes;  ///< j = 0 .. 20, least-squares fit weighted by the light's amplitude
  double rms_waves = 0.0;   ///< RMS without piston and tilts, including errors finer than modes
  double rms_with_tilt_waves = 0.0;  ///< RMS without piston
  /// Strehl ratio |sum A exp(i phi)|^2 / (sum A)^2 of the first diffraction order; `strehl` is
  /// without the tilts j = 1, 2, `strehl_with_tilt` includes the tilts.
  double strehl = 0.0;
  double strehl_with_tilt = 0.0;
  /// Diffraction efficiency of the first order: |mean field|^2 with all modes removed. Wavefront
  /// errors finer than the modes lower this number, too.
  double first_order = 0.0;
};

/// Ground-truth judge. Use it in one thread at a time. A verdict takes 100 to 300 ms; the first
/// verdict of each pattern takes longer.
class Judge {
 public:
  explicit Judge(const Config& config);

  /// Measures the residual wavefront for the grey levels shown on the SLM. Nothing is returned if
  /// the phase could not be unwrapped. `turbulence`: null if there is none.
  std::optional<Verdict> judge(Pattern pattern, const Image<std::uint8_t>& grey, const Light& light,
                               const Turbulence* turbulence, std::int64_t t_ns);
  /// Flatness error of the SLM: modes j = 0 .. 20 by least squares over the light in the pupil.
  /// Nothing is returned if the phase could not be unwrapped.
  std::optional<std::vector<Mode>> flatness_modes();
  /// True phase response of the SLM: phase of each grey level, waves.
  static std::array<double, 256> lut_waves(const SlmConfig& slm);

 private:
  struct Expected {
    Image<std::complex<float>> ideal;
    PupilBlocks blocks;
  };
  const Expected& expected(Pattern pattern);

  const Config config_;
  SlmModel slm_;
  Light light_;
  std::array<std::unique_ptr<Expected>, 2> expected_;  ///< one per Pattern, created on first use
};

}  // namespace ovws::twin
