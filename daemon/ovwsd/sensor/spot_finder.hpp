/// Looks for the spots that frames lose, as torn ones, and has them followed.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/rt/agent.hpp"
#include "core/tracking/cell_image.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/frame_inbox.hpp"
#include "daemon/ovwsd/sensor/search_policy.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/sensor/validity_watch.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

/// The search thread's agent. Frames that lack a spot, or whose spots no wavefront explains, make
/// it search one frame's whole image (ShapedAcquisition), when SearchPolicy says so. What it finds
/// becomes a new measurement plan: torn spots get templates of the shape that the wavefront gives
/// them. If all are round again, or the image of invalid frames is not explained, the ordinary plan
/// returns. Sensors of more than 200 spots, or of spots of more than 40 camera pixels of lambda/d,
/// are not searched.
class SpotFinder : public Agent {
 public:
  SpotFinder(const SlmGeometry& slm, FrameBroker& frames, SensorKeeper& keeper, Events& events);
  ~SpotFinder() override;

  bool do_work() override;

  /// Publish thread: every frame.
  void saw(const FrameRecord& record);
  /// Any thread: why no frame is valid; nothing if frames are.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid() const;
  /// Any thread: CLOCK_MONOTONIC time of the last search that found the spots; 0: none did.
  std::int64_t found_ns() const { return found_ns_.load(std::memory_order_relaxed); }

 private:
  struct Bench;
  bool make_bench(const FrameCopy& frame, const SensorSnapshot& sensor);
  void announce();
  bool look(const FrameCopy& frame, const SensorSnapshot& sensor, Doubt doubt);
  std::optional<TornSpots> search(const FrameCopy& frame, const SensorSnapshot& sensor);
  std::optional<TornSpots> explain(const FrameCopy& frame);
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
  // The publish thread's.
  int doubtful_in_a_row_ = 0, blind_in_a_row_ = 0;
  // The search thread's.
  SearchPolicy policy_;
  std::optional<CellImage> searched_;  ///< the image searched last
  std::int64_t doubted_ns_ = 0;        ///< when frames last lacked something
  std::int64_t next_look_ns_ = 0;
  std::uint64_t left_plan_id_ = 0;  ///< what it found takes the place of this plan
  std::int64_t left_ns_ = 0;
  std::int64_t announced_ns_ = 0;  ///< since when no frame is valid, as announced; 0: frames are
};

}  // namespace ovws
