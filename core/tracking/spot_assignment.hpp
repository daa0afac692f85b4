/// Spot assignment: which found spot belongs to which subaperture, for a smooth wavefront.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

/// Assigns found positions to predicted ones by a displacement field: an affine map (tilt, focus,
/// astigmatism) plus the mean residual of matched neighbours. A hypothesis assigns one of the
/// nearby positions to a seed subaperture near the centre. From there the field grows ring by ring.
/// Each round refits it by least squares with outlier rejection, so that displacements may exceed
/// the pitch as long as neighbours do not cross.
///
/// Its memory is allocated at construction, for one lattice and a maximum number of positions.
class SpotAssignment {
 public:
  static constexpr int kNone = -1;

  struct Rules {
    double min_share = 0.5;  ///< of the lattice that a match must explain
    /// Largest displacement of a seed that is tried.
    double max_shift_px = std::numeric_limits<double>::infinity();
  };

  SpotAssignment(std::vector<Vec2> predicted_px, int max_found);

  int size() const { return int(predicted_.size()); }
  /// The fewest spots that a match must explain: 3, or min_share of the lattice. RT-safe.
  int least_found(const Rules& rules) const OVWS_NONBLOCKING;

  /// For each subaperture the index of its position in `found`, or kNone; valid until the next
  /// call. The hypothesis that explains most positions wins; the smaller shift breaks ties. All are
  /// kNone if it explains fewer than least_found. `found` holds at most max_found positions.
  /// RT-safe.
  std::span<const int> match(std::span<const Vec2> found, const Rules& rules) OVWS_NONBLOCKING;
  std::span<const int> match(std::span<const Vec2> found) OVWS_NONBLOCKING {
    return match(found, Rules{});
  }

  /// Where subaperture i's spot should be according to the last match.
  Vec2 expected(int i) const OVWS_NONBLOCKING;
  /// Largest distance from there; beyond it the position may belong to a neighbour.
  double tolerance_px() const;
  double pitch_px() const { return pitch_; }  ///< median distance of nearest neighbours

 private:
  static constexpr int kStarts = 32;  ///< positions tried per seed, within some three pitches

  /// displacement(p) = shift + linear (p - centre)
  struct Field {
    Vec2 shift;
    std::array<double, 4> linear{};  ///< dx/dx, dx/dy, dy/dx, dy/dy
  };
  struct Choice {
    int position = kNone;
    double distance = 0.0;
  };

  void find_neighbours();
  void find_seeds();
  int nearest_positions(std::span<const Vec2> found, Vec2 at, std::array<int, kStarts>& out) const;
  int grow(std::span<const Vec2> found, int seed, Vec2 shift);
  std::span<const int> adopt_best(std::span<const Vec2> found);
  int assign(std::span<const Vec2> found, Vec2 from, double reach);
  Choice nearest(std::span<const Vec2> found, Vec2 at) const;
  bool fit(std::span<const Vec2> found);
  bool fit_within(std::span<const Vec2> found, double limit);
  void update_residuals(std::span<const Vec2> found);
  Vec2 affine(int i) const;

  std::vector<Vec2> predicted_;
  Vec2 centre_;
  double pitch_ = 0.0;
  double extent_ = 0.0;  ///< from the centre to the farthest subaperture
  std::vector<std::vector<int>> neighbours_;
  std::vector<int> seeds_;  ///< subapertures at and around the centre: any spot may be missing
  std::vector<int> by_y_;   ///< indices of the found positions, by increasing y
  Field field_;
  std::vector<int> matched_;  ///< subaperture -> position
  std::vector<int> owner_;    ///< position -> subaperture
  std::vector<Choice> choices_;
  std::vector<Vec2> residuals_;  ///< of matched subapertures, from the affine field
  std::vector<double> sorted_;
  Field best_field_;
  std::vector<int> best_matched_;
};

}  // namespace ovws
