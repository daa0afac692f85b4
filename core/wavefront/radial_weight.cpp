#include "core/wavefront/radial_weight.hpp"

#include <cmath>
#include <numbers>

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

double weight_at(const SlopeModel& model, const std::vector<RadialNode>& nodes, double r) {
  switch (model.kind) {
    case SlopeKind::zernike_tilt:
      return r;
    case SlopeKind::kernel_tilt:
      return kernel_weight(model, nodes, r);
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
  for (const RadialNode& n : legendre) {
    nodes.push_back({n.r, n.weight * n.r * weight_at(model, legendre, n.r)});
  }
  return nodes;
}

}  // namespace ovws
