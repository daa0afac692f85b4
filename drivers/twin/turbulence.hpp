/// Atmospheric turbulence in front of the SLM as frozen flow (Taylor's hypothesis): a fixed
/// wavefront that the wind carries over the pupil.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws::twin {

/// Lengths in pupil diameters.
struct TurbulenceConfig {
  /// RMS over the pupil and over all time, without piston and tilts (j >= 3).
  double rms_waves = 0.1;
  double speed_pupils_per_s = 1.0;
  double direction_deg = 0.0;  ///< where the air moves to: 0 is +x, 90 is +y (down)
  double outer_scale_pupils = 10.0;
  int seed = 1;
  bool tilt = true;  ///< false: piston and tilts over the pupil are removed at each moment

  friend bool operator==(const TurbulenceConfig&, const TurbulenceConfig&) = default;
};

/// Sum of 300 plane waves of random directions and phases. Their frequencies are spaced
/// logarithmically up to kMaxCycles per pupil, their power follows von Karman's spectrum (f^2 +
/// 1/L0^2)^(-11/6) (Hardy, "Adaptive Optics for Astronomical Telescopes", 1998, ch. 3). The same
/// configuration gives the same wavefront at the same time. Immutable, so thread-safe.
class Turbulence {
 public:
  static constexpr double kMaxCycles = 12.0;
  static constexpr int kModes = 21;  ///< j = 0 .. 20
  using Modes = std::array<double, kModes>;

  explicit Turbulence(const TurbulenceConfig& config);

  const TurbulenceConfig& config() const { return config_; }

  /// Wavefront in waves at a position in pupil radii from the pupil's centre, at `t_ns` UTC.
  double waves(Vec2 at, std::int64_t t_ns) const;
  /// Zernike coefficients over the pupil, RMS-normalised waves: exact by Noll's integrals ("Zernike
  /// polynomials and atmospheric turbulence", 1976).
  Modes modes(std::int64_t t_ns) const;

  /// Wavefront in waves at the points first + step (c, r), in pupil radii: `points` x `points`, by
  /// (c, r).
  Eigen::MatrixXf sample(Vec2 first, double step, int points, std::int64_t t_ns) const;

 private:
  struct Wave {
    Vec2 cycles_per_radius;  ///< spatial frequency
    double start_cycles = 0.0;
    double waves = 0.0;  ///< amplitude
    /// Complex amplitudes by OSA index, RMS-normalised waves: mode j's coefficient at a time is
    /// Re(modes[j] exp(i phase_at_centre)).
    std::array<std::complex<double>, kModes> modes{};
  };
  double phase_at_centre(const Wave& wave, std::int64_t t_ns) const;  ///< radians
  void fill_modes(Wave& wave) const;
  Modes all_modes(std::int64_t t_ns) const;  ///< including piston and tilts
  void scale_to_rms();

  TurbulenceConfig config_;
  Vec2 radii_per_s_;
  std::vector<Wave> waves_;
};

}  // namespace ovws::twin
