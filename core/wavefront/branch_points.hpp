/// Branch points: phase singularities of the incoming light, found by the circulation of the local
/// tilts.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// A phase singularity of the incoming light: the phase grows by `charge` waves on a path around it
/// that turns from +x to +y.
struct BranchPoint {
  Vec2 at;         ///< centre of the loop that encloses it, pupil radii from the pupil's centre
  int charge = 0;  ///< 1 or -1
};

constexpr int kMaxBranchPoints = 8;

/// Closed loops of neighbouring subapertures, and the circulation of the local tilts along them.
///
/// The circulation is the sum over the loop's edges of the mean tilt of both ends times the edge. A
/// smooth wavefront has none. A loop is either the smallest cell of the lattice (triangle or
/// square), or encloses one subaperture or two neighbouring ones, whose spots may be split or lost.
/// Each circulation is divided by that of a singularity at the loop's centre. The tilts are those
/// that a fit of modes leaves, because the mean of two tilts is exact for tilts that change
/// linearly only. Immutable after construction, which takes milliseconds.
class BranchPoints {
 public:
  /// Smallest circulation that counts as a branch point, waves.
  static constexpr double kMinCirculation = 0.5;
  /// Smallest circulation relative to the root sum square of the tilts that the modes leave, waves
  /// per subaperture: 1.5 or more for branch points, up to 1.1 for air without any.
  static constexpr double kMinShare = 1.25;

  /// `pupil_radius_px`: SLM pixels. `map`: from slopes to displacements (registration).
  BranchPoints(const Lattice& lattice, double pupil_radius_px, const PxPerCycle& map);

  /// Writes the branch points to `found`, the strongest first, and returns their number.
  /// `left_px`: displacement of each spot that the modes do not explain, camera pixels; NaN:
  /// unknown. `outlier`: the only spot without which modes explain the others, or -1. Loops with an
  /// unknown spot or with the outlier are left out. Of loops that share a spot, only the strongest
  /// counts. Linear in the number of subapertures. RT-safe.
  int find(std::span<const Vec2> left_px, int outlier,
           std::span<BranchPoint, kMaxBranchPoints> found) const OVWS_NONBLOCKING;

 private:
  static constexpr int kMaxCorners = 10;
  struct Loop {
    Vec2 at;  ///< SLM pixels from the pupil's centre
    int corners = 0;
    std::array<std::int16_t, kMaxCorners> spots{};  ///< in order along the loop
    std::array<Vec2, kMaxCorners> per_px{};         ///< waves per camera pixel
  };
  struct Suspect {
    const Loop* loop = nullptr;
    double waves = 0.0;
  };
  void add_loop(const Lattice& lattice, std::vector<int> spots, const PxPerCycle& map);
  static bool passes(const Loop& loop, int spot);
  static bool share_spot(const Loop& a, const Loop& b);
  static void keep(Suspect one, std::span<Suspect> suspects, int& count);

  std::vector<Loop> loops_;
  double pupil_radius_px_;
  double lambda_d_px_;  ///< displacement by a tilt of one wave per subaperture, camera pixels
};

}  // namespace ovws
