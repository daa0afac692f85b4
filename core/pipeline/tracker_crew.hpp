/// The tracker threads: each takes its slice of every frame, frame after frame, with no lock.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/track_stage.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

/// One frame at a time is tracked, by all workers at once. Whoever brings `waiting_` from 0 to 1,
/// or finishes a frame while others wait, starts the next one: nobody ever waits for another, and
/// all else that is not atomic here belongs to whoever does so.
class TrackerCrew {
 public:
  struct Config {
    int workers = 1;
    int records = 64;
  };
  struct Deps {
    TrackStage& stage;
    SpscRing<Entry*>& tracked;  ///< to the last stage, in frame order
  };

  TrackerCrew(const Config& config, const Deps& deps);

  /// Acquisition thread.
  void submit(Entry& entry) OVWS_NONBLOCKING;
  /// Worker k's thread: waits at most 20 ms for work. True if there was some.
  bool turn(int k);

 private:
  void start_next() OVWS_NONBLOCKING;
  void finish(Entry& entry) OVWS_NONBLOCKING;

  Deps deps_;
  SpscRing<Entry*> inbox_;
  std::vector<std::unique_ptr<SpscRing<Entry*>>> slices_;
  std::atomic<int> waiting_{0};  ///< frames submitted and not finished
  std::atomic<int> working_{0};  ///< slices of the present frame not finished
};

}  // namespace ovws
