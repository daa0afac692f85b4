/// Angles, phasors of phases in cycles, and the sinc function.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>

namespace ovws {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// exp(2 pi i cycles).
inline std::complex<double> unit_phasor(double cycles) {
  return std::polar(1.0, kTwoPi * cycles);
}

/// exp(2 pi i cycles) in single precision, for many cycles, too: whole ones are dropped first.
inline std::complex<float> wrapped_phasor(double cycles) {
  return std::complex<float>(unit_phasor(cycles - std::round(cycles)));
}

/// sin(pi x) / (pi x).
inline double sinc(double x) {
  const double angle = std::numbers::pi * x;
  return x == 0.0 ? 1.0 : std::sin(angle) / angle;
}

}  // namespace ovws
