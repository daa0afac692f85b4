/// Affine least-squares displacement field, and the lattice's neighbour lists.
#include "core/pipeline/neighbourhood.hpp"

#include <algorithm>
#include <limits>

#include "core/base/cholesky.hpp"

namespace ovws {
namespace {

Vec2 position(const SpotFix& fix) {
  return {double(fix.x), double(fix.y)};
}

}  // namespace

Vec2 DisplacementField::at(Vec2 scaled) const {
  const Eigen::Vector2d d = affine_.transpose() * Eigen::Vector3d(1.0, scaled.x, scaled.y);
  return {d.x(), d.y()};
}

Neighbourhood::Neighbourhood(const std::vector<Vec2>& predicted_px) : sites_(predicted_px.size()) {
  Vec2 centre;
  for (const Vec2 p : predicted_px) centre = centre + (1.0 / double(predicted_px.size())) * p;
  double extent_px = 1.0;
  for (const Vec2 p : predicted_px) extent_px = std::max(extent_px, norm(p - centre));
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    sites_[i].predicted_px = predicted_px[i];
    sites_[i].scaled = (1.0 / extent_px) * (predicted_px[i] - centre);
  }
  for (int i = 0; i < int(sites_.size()); ++i) find_neighbours(i);
}

void Neighbourhood::find_neighbours(int i) {
  Site& site = sites_[i];
  const auto distance = [&](int k) { return norm(sites_[k].predicted_px - site.predicted_px); };
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < int(sites_.size()); ++k) {
    if (k != i) nearest = std::min(nearest, distance(k));
  }
  if (sites_.size() < 2) nearest = 0.0;
  site.pitch_px = nearest;
  // A radius of 1.6 pitches contains the 6 neighbours in a hexagonal lattice and the 8 in a square
  // lattice, but no farther subapertures.
  for (int k = 0; k < int(sites_.size()) && site.neighbour_count < kMaxNeighbours; ++k) {
    if (k != i && distance(k) <= 1.6 * nearest) site.neighbours[site.neighbour_count++] = k;
  }
}

DisplacementField Neighbourhood::fit(std::span<const SpotFix> spots) const OVWS_NONBLOCKING {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> rhs = Eigen::Matrix<double, 3, 2>::Zero();
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if (!spots[i].found()) continue;
    const Eigen::Vector3d basis(1.0, sites_[i].scaled.x, sites_[i].scaled.y);
    const Vec2 d = position(spots[i]) - sites_[i].predicted_px;
    normal += basis * basis.transpose();
    rhs += basis * Eigen::RowVector2d(d.x, d.y);
  }
  DisplacementField field;
  if (normal(0, 0) < 0.5) return field;
  // Tikhonov damping: gradients that the found spots do not determine become zero.
  normal(1, 1) += 1e-6;
  normal(2, 2) += 1e-6;
  if (solve_positive(normal, rhs)) field.affine_ = rhs;
  return field;
}

Vec2 Neighbourhood::expect(int i, const DisplacementField& field,
                           std::span<const SpotFix> spots) const OVWS_NONBLOCKING {
  const Site& site = sites_[i];
  Vec2 residual;
  int found = 0;
  for (int n = 0; n < site.neighbour_count; ++n) {
    const int k = site.neighbours[n];
    if (!spots[k].found()) continue;
    const Site& other = sites_[k];
    residual = residual + (position(spots[k]) - other.predicted_px - field.at(other.scaled));
    ++found;
  }
  const Vec2 expected = site.predicted_px + field.at(site.scaled);
  return found > 0 ? expected + (1.0 / found) * residual : expected;
}

bool Neighbourhood::is_duplicate(int i, std::span<const SpotFix> spots) const OVWS_NONBLOCKING {
  const Site& site = sites_[i];
  if (!spots[i].found()) return false;
  return std::any_of(site.neighbours.begin(), site.neighbours.begin() + site.neighbour_count,
                     [&](int k) {
                       return spots[k].found() &&
                              norm(position(spots[k]) - position(spots[i])) < 0.25 * site.pitch_px;
                     });
}

}  // namespace ovws
