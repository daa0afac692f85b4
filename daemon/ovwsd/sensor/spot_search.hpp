/// Searches whole images for lost and split spots, and has them tracked.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/rt/agent.hpp"
#include "core/tracking/binned_image.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/sensor/search_policy.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/sensor/validity_watch.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

/// Agent of the search thread. If frames lose a spot, or no wavefront explains their spots, it
/// searches the whole image of one frame (ShapedAcquisition) when SearchPolicy permits. The result
/// becomes a new measurement plan, with templates for split spots of the shape that the wavefront
/// gives them. The ordinary plan returns when no spot is split any more, or when frames are invalid
/// and the search fails. Sensors with more than 200 spots, or with lambda/d above 40 camera pixels,
/// are not searched.
class SpotSearch : public Agent {
 public:
  SpotSearch(const SlmGeometry& slm, FrameBroker& frames, SensorKeeper& keeper, Events& events);
  ~SpotSearch() override;

  bool do_work() override;

  /// Publish thread: call for every frame.
  void on_frame(const FrameRecord& record);
  /// Any thread: why no frame is valid; nothing if frames are.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid() const;
  /// Any thread: CLOCK_MONOTONIC time of the last successful search; 0: none.
  std::int64_t found_ns() const { return found_ns_.load(std::memory_order_relaxed); }

 private:
  struct Bench;
  bool make_bench(const FrameCopy& frame, const SensorSnapshot& sensor);
  void announce();
  bool search_if_due(const FrameCopy& frame, const SensorSnapshot& sensor, Doubt doubt);
  std::optional<SplitSpots> search(const FrameCopy& frame, const SensorSnapshot& sensor);
  std::optional<SplitSpots> explain(const FrameCopy& frame);
  bool is_explained_plain(std::span<const SpotFix> fixes) const;

  SlmGeometry slm_;
  SensorKeeper& keeper_;
  Events& events_;
  FrameInbox inbox_;
  std::unique_ptr<Bench> bench_;
  std::atomic<Doubt> doubt_{Doubt::none};
  std::atomic<std::int64_t> found_ns_{0};
  ValidityWatch validity_;
  Guarded<SearchProgress> progress_;
  // Publish thread only.
  int doubtful_in_a_row_ = 0, blind_in_a_row_ = 0;
  // Search thread only.
  SearchPolicy policy_;
  std::optional<BinnedImage> searched_;  ///< the image searched last
  std::int64_t doubted_ns_ = 0;          ///< when frames were last doubtful
  std::int64_t next_check_ns_ = 0;
  std::uint64_t replaced_plan_id_ = 0;  ///< the plan that the last search replaced
  std::int64_t replaced_ns_ = 0;
  std::int64_t announced_ns_ = 0;  ///< start of the announced invalid period; 0: none
};

}  // namespace ovws
