#include "core/wavefront/branch_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

namespace ovws {
namespace {

constexpr double kTouching = 1.2;        // pitches: nearest neighbours
constexpr double kDiagonal = 1.6;        // and those across a square
constexpr double kEvidenceSpots = 37.0;  // beyond, more spots are no more evidence
/// A slope is measured by a spot inside the subaperture only if the singularity is outside.
constexpr double kMinDistancePx = 1.0;

using Lists = std::vector<std::vector<int>>;  // of each subaperture, ascending

/// The pitch of the lattice: the smallest distance of two subapertures.
double pitch_of(const Lattice& lattice) {
  double pitch_px = std::numeric_limits<double>::infinity();
  for (const Subaperture& a : lattice.subapertures) {
    for (const Subaperture& b : lattice.subapertures) {
      if (&a != &b) pitch_px = std::min(pitch_px, norm(a.centre_px - b.centre_px));
    }
  }
  return pitch_px;
}

Lists within(const Lattice& lattice, double distance_px) {
  const auto& all = lattice.subapertures;
  Lists lists(all.size());
  for (int i = 0; i < int(all.size()); ++i) {
    for (int k = i + 1; k < int(all.size()); ++k) {
      const Vec2 r = all[std::size_t(k)].centre_px - all[std::size_t(i)].centre_px;
      if (r.x * r.x + r.y * r.y >= distance_px * distance_px) continue;
      lists[std::size_t(i)].push_back(k);
      lists[std::size_t(k)].push_back(i);
    }
  }
  for (std::vector<int>& list : lists) std::sort(list.begin(), list.end());
  return lists;
}

/// The smallest cells of a square lattice whose first corner is `i`: the neighbour that a quarter
/// turn follows, and the corner across. Of a lattice of triangles: two later neighbours that touch.
Lists cells_at(const Lattice& lattice, int i, const Lists& touching, const Lists& diagonal) {
  const auto& all = lattice.subapertures;
  const auto from_i = [&](int k) {
    return all[std::size_t(k)].centre_px - all[std::size_t(i)].centre_px;
  };
  const bool square = &touching != &diagonal;
  const std::vector<int>& near = touching[std::size_t(i)];
  Lists cells;
  for (const int j : near) {
    for (const int k : near) {
      const std::vector<int>& beside = touching[std::size_t(j)];
      if (!square) {
        const bool touch = std::find(beside.begin(), beside.end(), k) != beside.end();
        if (i < j && j < k && touch) cells.push_back({i, j, k});
        continue;
      }
      const Vec2 a = from_i(j), b = from_i(k);
      if (a.x * b.y - a.y * b.x < 0.5 * norm(a) * norm(b)) continue;  // no quarter turn
      for (const int across : beside) {
        const bool corner = norm(from_i(across) - a - b) < 0.5 * norm(a);
        if (corner && i < std::min({j, k, across})) cells.push_back({i, j, k, across});
      }
    }
  }
  return cells;
}

/// Largest circulation of a loop for a root sum square displacement of one pixel, squared.
template <class Loop>
double reach(const Loop& loop) {
  double squares = 0.0;
  for (int k = 0; k < loop.corners; ++k) {
    const Vec2 per_px = loop.per_px[std::size_t(k)];
    squares += per_px.x * per_px.x + per_px.y * per_px.y;
  }
  return squares;
}

}  // namespace

BranchPoints::BranchPoints(const Lattice& lattice, double pupil_radius_px, const PxPerCycle& map)
    : pupil_radius_px_(pupil_radius_px), lambda_d_px_(map.scale() / lattice.diameter_px) {
  const double pitch_px = pitch_of(lattice);
  const Lists touching = within(lattice, kTouching * pitch_px);
  const Lists diagonal = within(lattice, kDiagonal * pitch_px);
  const bool square = touching != diagonal;
  const Lists& rings = square ? diagonal : touching;
  const std::size_t whole = square ? 8 : 6;  // neighbours of an inner subaperture
  for (std::size_t i = 0; i < rings.size(); ++i) {
    for (std::vector<int>& cell : cells_at(lattice, int(i), touching, rings)) {
      add_loop(lattice, std::move(cell), map);
    }
    if (rings[i].size() != whole) continue;
    add_loop(lattice, rings[i], map);
    for (const int j : touching[i]) {
      if (j < int(i) || rings[std::size_t(j)].size() != whole) continue;
      std::vector<int> both;
      const std::vector<int>& other = rings[std::size_t(j)];
      std::set_union(rings[i].begin(), rings[i].end(), other.begin(), other.end(),
                     std::back_inserter(both));
      both.erase(
          std::remove_if(both.begin(), both.end(), [&](int k) { return k == int(i) || k == j; }),
          both.end());
      add_loop(lattice, std::move(both), map);
    }
  }
  const auto farthest =
      std::max_element(loops_.begin(), loops_.end(),
                       [](const Loop& a, const Loop& b) { return reach(a) < reach(b); });
  if (farthest != loops_.end()) std::iter_swap(loops_.begin(), farthest);
}

void BranchPoints::add_loop(const Lattice& lattice, std::vector<int> spots, const PxPerCycle& map) {
  if (spots.size() > kMaxCorners) return;  // no lattice has such a loop
  const auto at = [&](int i) { return lattice.subapertures[std::size_t(i)].centre_px; };
  Loop loop;
  loop.corners = int(spots.size());
  for (const int i : spots) loop.at = loop.at + (1.0 / loop.corners) * at(i);
  const auto angle = [&](int i) {
    const Vec2 r = at(i) - loop.at;
    return std::atan2(r.y, r.x);
  };
  std::sort(spots.begin(), spots.end(), [&](int a, int b) { return angle(a) < angle(b); });
  double ideal = 0.0;
  std::array<Vec2, kMaxCorners> per_slope{};
  for (int k = 0; k < loop.corners; ++k) {
    const Vec2 before = at(spots[std::size_t((k + loop.corners - 1) % loop.corners)]);
    const Vec2 after = at(spots[std::size_t((k + 1) % loop.corners)]);
    per_slope[std::size_t(k)] = 0.5 * (after - before);  // both edges at this corner
    const Vec2 r = at(spots[std::size_t(k)]) - loop.at;
    const double square = std::max(r.x * r.x + r.y * r.y, kMinDistancePx);
    ideal += (r.x * per_slope[std::size_t(k)].y - r.y * per_slope[std::size_t(k)].x) /
             (2.0 * std::numbers::pi * square);
    loop.spots[std::size_t(k)] = std::int16_t(spots[std::size_t(k)]);
  }
  const double d = map.determinant();
  for (int k = 0; k < loop.corners; ++k) {
    const Vec2 w = (1.0 / (ideal * d)) * per_slope[std::size_t(k)];
    // The transposed inverse of the registration matrix.
    loop.per_px[std::size_t(k)] = {map.yy * w.x - map.yx * w.y, map.xx * w.y - map.xy * w.x};
  }
  loops_.push_back(loop);
}

bool BranchPoints::passes(const Loop& loop, int spot) {
  const auto end = loop.spots.begin() + loop.corners;
  return std::find(loop.spots.begin(), end, spot) != end;
}

bool BranchPoints::share_spot(const Loop& a, const Loop& b) {
  for (int k = 0; k < a.corners; ++k) {
    if (passes(b, a.spots[std::size_t(k)])) return true;
  }
  return false;
}

/// Adds a suspect to those kept so far, unless a stronger one shares a spot with it. Replaces
/// weaker ones that do.
void BranchPoints::keep(Suspect one, std::span<Suspect> suspects, int& count) {
  const auto begin = suspects.begin();
  const auto is_stronger = [&](const Suspect& other) {
    return share_spot(*one.loop, *other.loop) && std::abs(other.waves) >= std::abs(one.waves);
  };
  if (std::any_of(begin, begin + count, is_stronger)) return;
  const auto is_rival = [&](const Suspect& other) { return share_spot(*one.loop, *other.loop); };
  count = int(std::remove_if(begin, begin + count, is_rival) - begin);
  if (count < int(suspects.size())) suspects[std::size_t(count++)] = one;
}

int BranchPoints::find(std::span<const Vec2> left_px, int outlier,
                       std::span<BranchPoint, kMaxBranchPoints> found) const OVWS_NONBLOCKING {
  double squares = 0.0, known = 0.0;
  for (const Vec2& left : left_px) {
    if (std::isnan(left.x)) continue;
    squares += left.x * left.x + left.y * left.y;
    known += 1.0;
  }
  // In nearly all frames no loop can reach the limit: then the loops stay out of the cache.
  if (loops_.empty() || squares * reach(loops_.front()) <= kMinCirculation * kMinCirculation) {
    return 0;
  }
  const double share = std::sqrt(squares * std::min(1.0, kEvidenceSpots / std::max(known, 1.0)));
  const double limit = std::max(kMinCirculation, kMinShare * share / lambda_d_px_);
  std::array<Suspect, 2 * kMaxBranchPoints> suspects;
  int count = 0;
  for (const Loop& loop : loops_) {
    if (passes(loop, outlier)) continue;
    double waves = 0.0;
    for (int k = 0; k < loop.corners; ++k) {
      const Vec2 left = left_px[std::size_t(loop.spots[std::size_t(k)])];
      waves += left.x * loop.per_px[std::size_t(k)].x + left.y * loop.per_px[std::size_t(k)].y;
    }
    if (std::abs(waves) > limit) keep({&loop, waves}, suspects, count);  // never if NaN
  }
  const auto stronger = [](const Suspect& a, const Suspect& b) {
    return std::abs(a.waves) > std::abs(b.waves);
  };
  std::sort(suspects.begin(), suspects.begin() + count, stronger);
  count = std::min(count, kMaxBranchPoints);
  for (int k = 0; k < count; ++k) {
    const Suspect& one = suspects[std::size_t(k)];
    found[std::size_t(k)] = {(1.0 / pupil_radius_px_) * one.loop->at, one.waves > 0.0 ? 1 : -1};
  }
  return count;
}

}  // namespace ovws
