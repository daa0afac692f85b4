/// What the found spots of a frame say about a lost one: a smooth wavefront moves neighbours
/// together.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// Displacements from the predicted positions as a smooth function of the predicted position.
class DisplacementField {
 public:
  Vec2 at(Vec2 scaled) const;

 private:
  friend class Neighbourhood;
  Eigen::Matrix<double, 3, 2> affine_ = Eigen::Matrix<double, 3, 2>::Zero();
};

/// The lattice of predicted positions. Immutable after construction, which takes O(N^2) time.
class Neighbourhood {
 public:
  explicit Neighbourhood(const std::vector<Vec2>& predicted_px);

  /// Least-squares affine map (tilt, focus, astigmatism) of the found spots' displacements; with
  /// too few of them for a map, their mean. RT-safe.
  DisplacementField fit(std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

  /// Where spot i should be: predicted + field + what i's found neighbours leave over of the field.
  /// RT-safe.
  Vec2 expect(int i, const DisplacementField& field,
              std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

  /// Distance from spot i's predicted position to the nearest other.
  double pitch_px(int i) const { return sites_[i].pitch_px; }

  /// True if a found neighbour of i lies within a quarter of the pitch of i's own fix: two
  /// subapertures claim the same spot. RT-safe.
  bool doubled(int i, std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

 private:
  static constexpr int kMaxNeighbours = 8;
  struct Site {
    Vec2 predicted_px;
    Vec2 scaled;            ///< position in units of the lattice's extent, about its centre
    double pitch_px = 0.0;  ///< to the nearest neighbour
    int neighbour_count = 0;
    std::array<std::int32_t, kMaxNeighbours> neighbours{};
  };

  void find_neighbours(int i);

  std::vector<Site> sites_;
};

}  // namespace ovws
