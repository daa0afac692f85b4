#include "core/wavefront/radial_weight.hpp"

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>

#include "core/tracking/spot_geometry.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kNodes = 20;  // exact to degree 39: 24 of the mode, 1 of dA, and room for q
constexpr int kAngles = 96;

/// q(r) of the zero of Psi. With the pupil field P = exp(i l t) and the kernel's transfer function
/// g(a) = exp(-(pi w |a| / d)^2), Psi(0) = 0. A small phase phi shifts the zero by the mean of phi
/// under q(a) = Re conj(P(a)) integral P(b) (a - b) g(a - b) db. By symmetry q points along a, so
/// that a = (r, 0) suffices.
double kernel_weight(const SlopeModel& model, const std::vector<RadialNode>& nodes, double r) {
  const double k = std::pow(0.5 * kPi * model.kernel_radius, 2);  // radius of the pupil = 1 = d/2
  double sum = 0.0;
  for (const RadialNode& b : nodes) {
    double ring = 0.0;
    for (int i = 0; i < kAngles; ++i) {
      const double t = 2.0 * kPi * i / kAngles, c = std::cos(t);
      const double distance2 = r * r + b.r * b.r - 2.0 * r * b.r * c;
      ring += std::cos(model.charge * t) * (r - b.r * c) * std::exp(-k * distance2);
    }
    sum += b.weight * b.r * ring;
  }
  return sum;
}

double bessel_slope(int order, double x) {
  const double above = std::cyl_bessel_j(double(order + 1), x);
  return order == 0 ? -above : 0.5 * (std::cyl_bessel_j(double(order - 1), x) - above);
}

/// Integrand w(h^2) h^2 h' p of the matched filter at the radius p (lambda/d), w = 1 / (s + h^2), h
/// of maximum 1.
double matched_profile(int order, double peak, double p) {
  constexpr double kDifference = 1e-4;
  const double t = spot_intensity(order, p) / peak;
  const double slope =
      spot_amplitude(order, p + kDifference) - spot_amplitude(order, p - kDifference);
  return t / (kSlopeNoise + t) * slope * p;
}

/// q of the matched filter at every node. The fitted shift is proportional to the integral of w
/// (dT/dx) dI over the window, and a small phase phi changes the intensity T = |A|^2 by dI = 2 Re
/// conj(A) F[i phi P]. With A = i^l e^(ilt) h(p), exchanging the integrals leaves the angular
/// factor cos t and q(r) = integral_0^R w(h^2) h^2 h' J_l'(pi p r) p dp, r in units of the
/// subaperture's radius.
std::vector<double> matched_weights(const SlopeModel& model, const std::vector<RadialNode>& nodes) {
  constexpr int kSteps = 240;
  const int order = std::abs(model.charge);
  const double peak = spot_intensity(order, spot_geometry(order).ring);
  std::vector<double> q(nodes.size());
  for (int k = 0; k < kSteps; ++k) {
    const double p = (k + 0.5) * model.kernel_radius / kSteps;
    const double profile = matched_profile(order, peak, p);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      q[i] += profile * bessel_slope(order, kPi * p * nodes[i].r);
    }
  }
  return q;
}

double weight_at(const SlopeModel& model, const std::vector<RadialNode>& nodes, double r) {
  switch (model.kind) {
    case SlopeKind::zernike_tilt:
      return r;
    case SlopeKind::kernel_tilt:
      return kernel_weight(model, nodes, r);
    case SlopeKind::matched_tilt:  // radial_nodes applies matched_weights
    case SlopeKind::gradient_tilt:
    case SlopeKind::vortex_tilt:
      return 1.0;
  }
  return 1.0;
}

}  // namespace

std::vector<RadialNode> gauss_legendre(int count) {
  std::vector<RadialNode> nodes;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (count + 0.5));
    double slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p = 1.0, before = 0.0;
      for (int n = 1; n <= count; ++n) {
        const double next = ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n;
        before = p;
        p = next;
      }
      slope = count * (x * p - before) / (x * x - 1.0);
      const double step = p / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)});
  }
  return nodes;
}

std::vector<RadialNode> radial_nodes(const SlopeModel& model) {
  if (model.kind == SlopeKind::gradient_tilt) return {{1.0, 1.0}};
  const std::vector<RadialNode> legendre = gauss_legendre(kNodes);
  std::vector<RadialNode> nodes;
  nodes.reserve(legendre.size());
  const bool matched = model.kind == SlopeKind::matched_tilt;
  const std::vector<double> q =
      matched ? matched_weights(model, legendre) : std::vector<double>(legendre.size(), 1.0);
  for (std::size_t i = 0; i < legendre.size(); ++i) {
    const RadialNode& n = legendre[i];
    nodes.push_back({n.r, n.weight * n.r * q[i] * weight_at(model, legendre, n.r)});
  }
  return nodes;
}

}  // namespace ovws
