/// Looks for the spots that frames lose, as torn ones, and has them followed.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/rt/agent.hpp"
#include "daemon/frame_inbox.hpp"
#include "daemon/instrument.hpp"

namespace ovws {

/// The search thread's agent. Some frames in a row that lack a spot, or whose spots no
/// wavefront explains, make it search one frame's whole image (ShapedAcquisition). What it finds
/// becomes a new measurement plan: torn spots get templates of the shape that the wavefront gives
/// them. If all are round again, or the image is not explained, the ordinary plan returns. After a
/// search without result it waits, each time longer. Sensors of more than 200 spots, or of spots of
/// more than 40 camera pixels of lambda/d, are not searched.
class SpotFinder : public Agent {
 public:
  SpotFinder(const SlmGeometry& slm, Instrument& instrument);
  ~SpotFinder() override;

  bool do_work() override;

  /// Publish thread: every frame.
  void saw(const FrameRecord& record);
  FrameTaker& taker() { return inbox_; }

 private:
  struct Bench;
  bool make_bench(const FrameCopy& frame, const SensorSnapshot& sensor);
  std::optional<TornSpots> search(const FrameCopy& frame, const SensorSnapshot& sensor);
  std::optional<TornSpots> explain(const FrameCopy& frame);

  SlmGeometry slm_;
  Instrument& instrument_;
  FrameInbox inbox_;
  std::unique_ptr<Bench> bench_;
  std::atomic<bool> doubtful_{false};  ///< the newest frames are, several in a row
  int doubtful_in_a_row_ = 0;          ///< publish thread's
  std::int64_t next_ns_ = 0;
  std::int64_t pause_ns_;
};

}  // namespace ovws
