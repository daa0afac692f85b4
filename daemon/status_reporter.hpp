/// Says how the daemon is: the status message, systemd's status line, and the watchdog's food.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>

#include "core/control/state_machine.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "daemon/camera_actor.hpp"
#include "daemon/client_guard.hpp"
#include "daemon/daemon_store.hpp"
#include "daemon/image_publisher.hpp"
#include "daemon/instrument.hpp"
#include "daemon/jobs.hpp"
#include "daemon/live_refiner.hpp"
#include "daemon/loop/closed_loop.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/reload.hpp"
#include "daemon/slm_loop.hpp"
#include "daemon/spot_finder.hpp"
#include "daemon/state_keeper.hpp"
#include "daemon/stream_queue.hpp"
#include "daemon/thread_plan.hpp"
#include "proto/messages.hpp"

namespace ovws {

struct StatusDeps {
  const StateKeeper& state;
  const CameraActor& camera;
  const SlmLoop& slm;
  const Instrument& instrument;
  const SpotFinder& finder;
  const ImagePublisher& images;
  const ClosedLoop& loop;
  const LiveRefiner& refiner;
  const Recorder& recorder;
  const Jobs& jobs;
  Pipeline& pipeline;
  LatencyHistogram& published_latency;
  Counters& counters;
  Events& events;
  const DaemonStore& store;
  StreamQueue& queue;
  ThreadPlan& threads;
  Reloader& reloader;
  ClientGuard& clients;
  /// The stop has been asked for, and the display holds the main thread: does not return.
  std::function<void()> end_without_display;
};

/// The status thread's agent: once a second, and at once when something changed.
class StatusReporter : public Agent {
 public:
  explicit StatusReporter(StatusDeps deps);

  bool do_work() override;
  /// Thread-safe: status as of now; rates and latencies are those of the last status message.
  StatusMessage current() const;

 private:
  struct Measured {
    StatusMessage::Rates rates;
    std::vector<std::pair<std::string, LatencySummary>> latency;
  };
  struct Marks {
    std::int64_t t_ns = 0;
    std::uint64_t grabbed = 0, published = 0, images = 0;
  };
  void measure();
  void watch_threads();
  void feed_watchdog();

  StatusDeps deps_;
  std::int64_t started_ns_;
  std::int64_t next_ns_ = 0;
  std::int64_t next_food_ns_ = 0;
  std::set<const ThreadRow*> hung_;  ///< and said so
  Marks marks_;
  Guarded<Measured> measured_;
};

}  // namespace ovws
