/// Disturbance of the light in front of the SLM: atmospheric turbulence as frozen flow (Taylor's
/// hypothesis: the wind moves a fixed wavefront across the pupil), and vibrations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws::twin {

/// A layer of air, which moves as a whole.
struct AirLayer {
  double strength = 1.0;  ///< its part of the wavefront's variance, relative to the other layers
  double speed_pupils_per_s = 1.0;
  double direction_deg = 0.0;  ///< as TurbulenceConfig::direction_deg

  friend bool operator==(const AirLayer&, const AirLayer&) = default;
};

/// A sinusoidal vibration of one Zernike mode.
struct Vibration {
  int j = 1;               ///< OSA/ANSI index, 1 .. 20
  double rms_waves = 0.0;  ///< RMS over time of the RMS-normalised coefficient
  double frequency_hz = 0.0;

  friend bool operator==(const Vibration&, const Vibration&) = default;
};

/// Configuration of the turbulence. Lengths are in pupil diameters.
struct TurbulenceConfig {
  /// RMS of the wavefront over the pupil and over time, without piston and tilts (j >= 3).
  double rms_waves = 0.1;
  double speed_pupils_per_s = 1.0;
  double direction_deg = 0.0;  ///< direction of the wind: 0 blows to +x, 90 to +y (down)
  double outer_scale_pupils = 10.0;
  int seed = 1;
  bool tilt = true;  ///< false: piston and tilts of the air are removed at each moment
  std::vector<AirLayer> layers{};  ///< empty: one, of the speed and direction above
  std::vector<Vibration> vibrations{};

  friend bool operator==(const TurbulenceConfig&, const TurbulenceConfig&) = default;
};

/// Turbulent wavefront: a sum of 300 plane waves of random directions and phases, in turn of each
/// layer. Their frequencies are spaced logarithmically up to kMaxCycles per pupil. Their power
/// follows von Karman's spectrum (f^2 + 1/L0^2)^(-11/6) (Hardy, "Adaptive Optics for Astronomical
/// Telescopes", 1998, ch. 3). Vibrations are added, each of phase 0 at UTC 0. Configuration and
/// time determine the wavefront completely. Immutable, so thread-safe.
class Turbulence {
 public:
  static constexpr double kMaxCycles = 12.0;
  static constexpr int kModes = 21;  ///< j = 0 .. 20
  using Modes = std::array<double, kModes>;

  explicit Turbulence(const TurbulenceConfig& config);

  const TurbulenceConfig& config() const { return config_; }

  /// Wavefront in waves at time `t_ns` (UTC). `at`: position relative to the pupil's centre, in
  /// pupil radii.
  double waves(Vec2 at, std::int64_t t_ns) const;
  /// Zernike coefficients over the pupil at time `t_ns`, RMS-normalised waves. Exact, by Noll's
  /// integrals ("Zernike polynomials and atmospheric turbulence", 1976).
  Modes modes(std::int64_t t_ns) const;

  /// Wavefront in waves on a grid of `points` x `points` positions first + step (c, r), in pupil
  /// radii; element (c, r) of the result.
  Eigen::MatrixXf sample(Vec2 first, double step, int points, std::int64_t t_ns) const;

 private:
  struct Wave {
    Vec2 cycles_per_radius;  ///< spatial frequency, cycles per pupil radius
    Vec2 radii_per_s;        ///< its layer's motion
    double start_cycles = 0.0;
    double waves = 0.0;  ///< amplitude, waves
    /// Complex amplitudes of the Zernike modes by OSA index, RMS-normalised waves. The coefficient
    /// of mode j at a time is Re(modes[j] exp(i phase_at_centre)).
    std::array<std::complex<double>, kModes> modes{};
  };
  double phase_at_centre(const Wave& wave, std::int64_t t_ns) const;  ///< radians
  void fill_modes(Wave& wave) const;
  Modes air_modes(std::int64_t t_ns) const;  ///< without vibrations, with piston and tilts
  Modes vibration_modes(std::int64_t t_ns) const;
  Modes added_modes(std::int64_t t_ns) const;
  void scale_to_rms();

  TurbulenceConfig config_;
  std::vector<Wave> waves_;
};

}  // namespace ovws::twin
