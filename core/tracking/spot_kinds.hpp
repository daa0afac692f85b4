/// Kinds of spots: the spots of a sensor whose charges differ in size, each kind with its tracker.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Kinds of spots of a sensor. Spots are of one kind if their charges have the same size: those of
/// the charges l and -l have the same intensity for a flat wavefront. Immutable; all threads share
/// one object.
class SpotKinds {
 public:
  /// Makes the kinds of spots with these charges, one per subaperture. `like`: their size and the
  /// lit pixels. Null: all are like `like`, and make_tracker suffices. Errors: those of
  /// make_tracker for any of the kinds.
  static Result<std::shared_ptr<const SpotKinds>> make(const TrackingConfig& config,
                                                       const SpotModel& like,
                                                       std::span<const int> charges);

  int count() const { return int(kinds_.size()); }
  /// Kind of each subaperture's spot, from 0 on.
  const std::vector<int>& of_spots() const { return of_spots_; }
  /// Level (SpotFix::level) of each spot at equal light, relative to a bright spot.
  std::span<const float> levels() const { return levels_; }
  int spots_of(int kind) const { return kinds_[std::size_t(kind)].spots; }
  const SpotModel& model(int kind) const { return kinds_[std::size_t(kind)].model; }
  const SpotTracker& tracker(int kind) const { return *kinds_[std::size_t(kind)].tracker; }
  const SpotTracker& tracker_of(int spot) const OVWS_NONBLOCKING {
    return *kinds_[std::size_t(of_spots_[std::size_t(spot)])].tracker;
  }
  /// Working memory that suffices for each of the trackers.
  TrackScratch make_scratch() const;

 private:
  struct Kind {
    SpotModel model;
    std::unique_ptr<const SpotTracker> tracker;
    int spots = 0;  ///< number of subapertures
  };

  SpotKinds() = default;

  std::vector<Kind> kinds_;
  std::vector<int> of_spots_;
  std::vector<float> levels_;
};

}  // namespace ovws
