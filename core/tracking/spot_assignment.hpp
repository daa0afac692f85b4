/// Spot assignment: which found spot belongs to which subaperture, for a smooth wavefront.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

/// Spot assignment by a displacement field from predicted to found positions: an affine map (tilt,
/// focus, astigmatism) plus the mean residual of matched neighbours. A hypothesis assigns a found
/// position to a seed subaperture near the centre. The field then grows from the seed ring by ring.
/// Each round refits the field by least squares with outlier rejection, so that displacements may
/// exceed the pitch as long as neighbours do not cross.
///
/// If no field that begins without a gradient explains nearly all positions, fields that begin with
/// defocus or astigmatism are tried, too: growth alone finds gradients up to about 0.35, with them
/// up to 0.5.
///
/// A growth ends early if it repeats another one or cannot explain as much as the best one, because
/// a round takes 0.1 ms with 1,200 subapertures. The search ends with a field of less than half a
/// pitch that explains all positions but a few.
///
/// The constructor allocates all memory, for one lattice and at most `max_found` positions.
class SpotAssignment {
 public:
  static constexpr int kNone = -1;

  struct Rules {
    double min_share = 0.5;  ///< least share of the subapertures for which a match has a spot
    /// Largest displacement tried for the spot of the seed (the subaperture at which a match
    /// begins), camera pixels.
    double max_shift_px = std::numeric_limits<double>::infinity();
  };

  /// `kinds`: kind of spot of each subaperture, see SpotKinds; empty: all are of one kind.
  SpotAssignment(std::vector<Vec2> predicted_px, int max_found, std::vector<int> kinds = {});

  int size() const { return int(predicted_.size()); }
  /// Minimum number of spots that a match must explain: min_share of the lattice, at least 3.
  /// RT-safe.
  int least_found(const Rules& rules) const OVWS_NONBLOCKING;

  /// Assigns spots: for each subaperture the index of its position in `found`, or kNone; valid
  /// until the next call. The hypothesis that explains most positions wins, but a smaller shift
  /// wins if it explains only a few fewer: where light falls beyond the lattice, a lost spot at its
  /// rim makes a shift by a pitch explain one more. Every index is kNone if no hypothesis explains
  /// least_found spots. `found` holds at most max_found positions. `found_kinds`: kind of each
  /// position, if the subapertures have kinds; a subaperture only gets positions of its kind.
  /// RT-safe.
  std::span<const int> match(std::span<const Vec2> found, const Rules& rules,
                             std::span<const int> found_kinds = {}) OVWS_NONBLOCKING;
  std::span<const int> match(std::span<const Vec2> found) OVWS_NONBLOCKING {
    return match(found, Rules{});
  }

  /// Expected position of subaperture i's spot by the last match, camera pixels.
  Vec2 expected(int i) const OVWS_NONBLOCKING;
  /// Largest distance of a spot from expected(i); a spot farther away may be a neighbour's.
  double tolerance_px() const;
  double pitch_px() const { return pitch_; }  ///< median distance of nearest neighbours
  /// The part of the image within `pitches` of the predicted positions, and what they enclose.
  Disc part_around(double pitches) const { return {centre_, extent_ + pitches * pitch_}; }
  int growths() const { return growths_; }  ///< number of fields that the last match has grown

 private:
  static constexpr int kStarts = 32;  ///< positions tried per seed, within about three pitches

  /// Affine displacement field: displacement(p) = shift + linear (p - centre), camera pixels.
  using Linear = std::array<double, 4>;  ///< dx/dx, dx/dy, dy/dx, dy/dy
  struct Field {
    Vec2 shift;
    Linear linear{};
  };
  struct Choice {
    int position = kNone;
    double distance = 0.0;
  };

  void find_neighbours();
  void find_seeds();
  bool of_kind(int subaperture, int position) const;
  void match_from(std::span<const Vec2> found, const Rules& rules, const Linear& linear,
                  int most_starts);
  int nearest_positions(std::span<const Vec2> found, int seed, std::array<int, kStarts>& out) const;
  bool is_settled() const;
  bool is_better(int explained, double shift, std::size_t found) const;
  int grow(std::span<const Vec2> found, const Rules& rules, int seed, Field first);
  bool repeats(int count) const;
  std::span<const int> adopt_best(std::span<const Vec2> found);
  int assign(std::span<const Vec2> found, Vec2 from, double reach);
  Choice nearest(std::span<const Vec2> found, int i) const;
  bool fit(std::span<const Vec2> found);
  bool fit_within(std::span<const Vec2> found, double limit);
  void update_residuals(std::span<const Vec2> found);
  Vec2 affine(int i) const;

  std::vector<Vec2> predicted_;
  std::vector<int> kinds_;
  std::span<const int> found_kinds_;  ///< during a match
  Vec2 centre_;
  double pitch_ = 0.0;
  double extent_ = 0.0;  ///< from the centre to the farthest subaperture
  std::vector<std::vector<int>> neighbours_;
  std::vector<int> seeds_;  ///< several near the centre, because any single spot may be missing
  std::vector<int> by_y_;   ///< indices of the found positions, by increasing y
  Field field_;
  std::vector<int> matched_;  ///< index of the found position of each subaperture
  std::vector<int> owner_;    ///< index of the subaperture of each found position
  std::vector<Choice> choices_;
  std::vector<Vec2> residuals_;  ///< found minus affine position of matched subapertures, pixels
  std::vector<double> sorted_;
  int most_explained_ = 0;
  double smallest_shift_ = 0.0;  ///< of the best match
  Field best_field_;
  std::vector<int> best_matched_;
  std::vector<std::vector<int>> grown_;  ///< the matches of the first growths of a match
  int grown_count_ = 0;
  int few_;          ///< number of positions that a field need not explain to end the search
  int many_;         ///< more of them make a larger shift more likely
  int all_ = 0;      ///< number of positions that a match can explain at most
  int reached_ = 0;  ///< number of subapertures that the growth has reached
  int growths_ = 0;
};

}  // namespace ovws
