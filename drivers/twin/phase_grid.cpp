#include "drivers/twin/phase_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovws::twin {
namespace {

/// Weights of the values at `nodes` for a polynomial's value at `at` (Lagrange interpolation).
template <class Nodes, class Weights>
void lagrange(const Nodes& nodes, double at, Weights weights) {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    double weight = 1.0;
    for (std::size_t other = 0; other < nodes.size(); ++other) {
      if (other != k) weight *= (at - nodes[other]) / (nodes[k] - nodes[other]);
    }
    weights(k) = float(weight);
  }
}

}  // namespace

PhaseGrid PhaseGrid::covering(double reach_um, double step_um) {
  const int margin = 3;  // grid points that six taps need beyond a position
  return {step_um, 2 * (int(std::ceil(reach_um / step_um)) + margin) + 1};
}

LensletInterpolation::Node LensletInterpolation::node_at(const PhaseGrid& grid, Vec2 at_um) {
  static constexpr std::array<double, kTaps> kPoints{0, 1, 2, 3, 4, 5};
  const auto along = [&grid](double um, auto& weights) {
    const double at = (um - grid.first_um()) / grid.step_um;
    const int first = std::clamp(int(std::floor(at)) - (kTaps / 2 - 1), 0, grid.points - kTaps);
    lagrange(kPoints, at - first,
             [&weights](std::size_t k) -> float& { return weights[Eigen::Index(k)]; });
    return first;
  };
  Node node;
  node.x = along(at_um.x, node.along_x);
  node.y = along(at_um.y, node.along_y);
  return node;
}

LensletInterpolation::LensletInterpolation(const PhaseGrid& grid,
                                           const std::vector<Vec2>& centres_um, Vec2 along_x,
                                           Vec2 along_y, double side_um, int samples)
    : to_samples_(samples, kNodes) {
  std::array<double, kNodes> nodes{};
  for (int k = 0; k < kNodes; ++k) {
    nodes[std::size_t(k)] = -std::cos(std::numbers::pi * (k + 0.5) / kNodes);
  }
  for (int s = 0; s < samples; ++s) {
    lagrange(nodes, (2.0 * s + 1.0) / samples - 1.0,
             [&](std::size_t k) -> float& { return to_samples_(s, Eigen::Index(k)); });
  }
  lenslets_.reserve(centres_um.size());
  for (const Vec2 centre : centres_um) {
    Nodes& lenslet = lenslets_.emplace_back();
    for (std::size_t n = 0; n < lenslet.size(); ++n) {
      const Vec2 at = centre + side_um / 2 * nodes[n % kNodes] * along_x +
                      side_um / 2 * nodes[n / kNodes] * along_y;
      lenslet[n] = node_at(grid, at);
    }
  }
}

void LensletInterpolation::at_samples(const Eigen::MatrixXf& values, std::size_t lenslet,
                                      Eigen::MatrixXf& out) const {
  NodeMatrix at_nodes;
  for (std::size_t n = 0; n < lenslets_[lenslet].size(); ++n) {
    const Node& node = lenslets_[lenslet][n];
    const auto around = values.block<kTaps, kTaps>(node.x, node.y);
    at_nodes(Eigen::Index(n)) = node.along_x.dot(around * node.along_y);
  }
  out.noalias() = to_samples_ * at_nodes * to_samples_.transpose();
}

}  // namespace ovws::twin
