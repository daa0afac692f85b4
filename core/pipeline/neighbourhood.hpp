/// Predicts lost spots by an affine fit to the found ones: a smooth wavefront moves neighbouring
/// spots together.
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

/// Affine displacement field: displacement from the predicted position over the scaled position.
class DisplacementField {
 public:
  Vec2 at(Vec2 scaled) const;

 private:
  friend class Neighbourhood;
  Eigen::Matrix<double, 3, 2> affine_ = Eigen::Matrix<double, 3, 2>::Zero();
};

/// Predicted spot positions and their neighbours. Immutable after construction, which is O(N^2).
class Neighbourhood {
 public:
  explicit Neighbourhood(const std::vector<Vec2>& predicted_px);

  /// Least-squares affine map (tilt, focus, astigmatism) of the found spots' displacements. With
  /// too few found spots, the map is their mean displacement. RT-safe.
  DisplacementField fit(std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

  /// Expected position of spot i: predicted position + field + mean fit residual of the found
  /// neighbours of i. RT-safe.
  Vec2 expect(int i, const DisplacementField& field,
              std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

  /// Distance between the predicted positions of spot i and of its nearest neighbour, camera px.
  double pitch_px(int i) const { return sites_[i].pitch_px; }

  /// True if a found neighbour lies within a quarter of the pitch of spot i: both subapertures
  /// track the same spot. RT-safe.
  bool is_duplicate(int i, std::span<const SpotFix> spots) const OVWS_NONBLOCKING;

 private:
  static constexpr int kMaxNeighbours = 8;
  struct Site {
    Vec2 predicted_px;
    Vec2 scaled;            ///< position relative to the lattice's centre, in units of its extent
    double pitch_px = 0.0;  ///< distance to the nearest neighbour
    int neighbour_count = 0;
    std::array<std::int32_t, kMaxNeighbours> neighbours{};
  };

  void find_neighbours(int i);

  std::vector<Site> sites_;
};

}  // namespace ovws
