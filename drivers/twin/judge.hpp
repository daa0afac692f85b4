/// What the bench truly does to the light: how far it is from what the daemon means it to be.
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

/// The light on the SLM times the conjugate of the ideal hologram: hidden aberration, turbulence,
/// flatness error, and what is shown through the twin's own SLM. Light inside the subapertures, or
/// inside the pupil for the grating. Waves are RMS-normalised.
struct Verdict {
  std::vector<Mode> modes;           ///< j = 0 .. 20 by least squares over that light
  double rms_waves = 0.0;            ///< of what is not piston or tilt, finer than the modes, too
  double rms_with_tilt_waves = 0.0;  ///< of all but piston
  /// |sum A exp(i phi)|^2 / (sum A)^2 of the first order, phi without and with the tilts j = 1, 2.
  double strehl = 0.0;
  double strehl_with_tilt = 0.0;
  /// |mean of the light|^2 with all modes taken out: the part of the light that the first order
  /// gets. What the modes cannot follow lowers it, too.
  double first_order = 0.0;
};

/// One thread at a time. A verdict takes some 100 to 300 ms of one thread, the first of each
/// pattern more.
class Judge {
 public:
  explicit Judge(const Config& config);

  /// None if the wavefront could not be unwrapped. `turbulence`: null for none.
  std::optional<Verdict> judge(Pattern pattern, const Image<std::uint8_t>& grey,
                               const std::vector<Mode>& aberration, const Turbulence* turbulence,
                               std::int64_t t_ns);
  /// The error of the SLM's surface, j = 0 .. 20 by least squares over the light in the pupil; none
  /// if it could not be unwrapped.
  std::optional<std::vector<Mode>> flatness_modes();
  /// The phase that each grey level truly has, waves.
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
  std::array<std::unique_ptr<Expected>, 2> expected_;  ///< by pattern, once it was asked for
};

}  // namespace ovws::twin
