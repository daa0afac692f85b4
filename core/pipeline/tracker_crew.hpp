/// Lock-free fork-join over the tracker threads: each one tracks its slice of every frame.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/track_stage.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

/// Tracker workers; all of them track one frame at a time. The thread that increments `waiting_`
/// from 0 to 1, or that finishes a frame while others wait, starts the next frame. No thread waits
/// for another, and only the thread that starts a frame uses the non-atomic state.
class TrackerCrew {
 public:
  /// `tracked`: ring to the last stage, which receives the frames in order.
  TrackerCrew(int workers, int records, TrackStages& stage, SpscRing<Entry*>& tracked);

  /// Acquisition thread: queues a frame for tracking.
  void submit(Entry& entry) OVWS_NONBLOCKING;
  /// Worker k's thread: waits at most 20 ms for a slice and tracks it. False: no slice came.
  bool run_worker(int k);

 private:
  void start_next() OVWS_NONBLOCKING;
  void finish(Entry& entry) OVWS_NONBLOCKING;

  TrackStages& stage_;
  SpscRing<Entry*>& tracked_;
  SpscRing<Entry*> inbox_;
  std::vector<std::unique_ptr<SpscRing<Entry*>>> slices_;
  std::atomic<int> waiting_{0};  ///< frames submitted but not finished
  std::atomic<int> working_{0};  ///< unfinished slices of the current frame
};

}  // namespace ovws
