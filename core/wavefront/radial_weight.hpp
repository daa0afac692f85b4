/// Radial weight q(r) with which a tracker averages the phase inside a subaperture.
#pragma once

#include <vector>

#include "core/wavefront/slope_model.hpp"

namespace ovws {

/// Quadrature on the radius: integral_0^1 f(r) q(r) r dr = sum weight_k f(r_k).
struct RadialNode {
  double r = 0.0;
  double weight = 0.0;
};

/// Quadrature nodes for the weight q of a slope model. Exact for polynomials f up to degree 24
/// (kernel_tilt: to rounding, as q is analytic).
std::vector<RadialNode> radial_nodes(const SlopeModel& model);

/// Gauss-Legendre nodes and weights on [0, 1].
std::vector<RadialNode> gauss_legendre(int count);

}  // namespace ovws
