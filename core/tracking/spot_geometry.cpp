#include "core/tracking/spot_geometry.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace ovws {
namespace {

constexpr double kStep = 0.02;  // step of the radius, lambda/d

/// The first radius from `from` on where `stop(intensity, next intensity)` holds.
template <class Stop>
double walk(int charge, double from, Stop stop) {
  double here = spot_intensity(charge, from);
  for (double radius = from;; radius += kStep) {
    const double next = spot_intensity(charge, radius + kStep);
    if (stop(here, next)) return radius;
    here = next;
  }
}

SpotGeometry computed_geometry(int charge) {
  const auto falls = [](double here, double next) { return next < here; };
  const auto rises = [](double here, double next) { return next > here; };
  SpotGeometry g;
  if (charge != 0) {
    g.ring = walk(charge, 0.0, falls);
    const double half = 0.5 * spot_intensity(charge, g.ring);
    g.ring_inner = walk(charge, 0.0, [half](double here, double) { return here >= half; });
  }
  const double half = 0.5 * spot_intensity(charge, g.ring);
  g.ring_outer = walk(charge, g.ring, [half](double here, double) { return here <= half; });
  g.dark = walk(charge, g.ring_outer, rises);
  return g;
}

}  // namespace

double spot_amplitude(int charge, double radius) {
  // Simpson's rule: the integrand is smooth and has about radius/2 oscillations.
  const int order = std::abs(charge);
  const int half_steps = 12 + 2 * int(std::ceil(radius));
  const double h = 0.5 / half_steps;
  double sum = 0.0;
  for (int k = 1; k <= 2 * half_steps; ++k) {
    const double s = h * k;
    const double weight = k == 2 * half_steps ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * s * std::cyl_bessel_j(double(order), std::numbers::pi * radius * s);
  }
  return sum * h / 3.0;
}

double spot_intensity(int charge, double radius) {
  const double amplitude = spot_amplitude(charge, radius);
  return amplitude * amplitude;
}

SpotGeometry spot_geometry(int charge) {
  constexpr int kKept = 9;  // charges 0 to 8, all that can be tracked
  static const auto kept = [] {
    std::array<SpotGeometry, kKept> all;
    for (int order = 0; order < kKept; ++order) all[std::size_t(order)] = computed_geometry(order);
    return all;
  }();
  const int order = std::abs(charge);
  return order < kKept ? kept[std::size_t(order)] : computed_geometry(order);
}

}  // namespace ovws
