/// The status reporter: status messages, systemd's status line, and the systemd watchdog.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/access/client_guard.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/fitter/live_refiner.hpp"
#include "daemon/ovwsd/fitter/wavefront_search.hpp"
#include "daemon/ovwsd/lease/leases.hpp"
#include "daemon/ovwsd/library/library.hpp"
#include "daemon/ovwsd/loop/closed_loop.hpp"
#include "daemon/ovwsd/record/recorder.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/reload.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// The versions of ovws and of its numerical library, Eigen, by name.
std::vector<std::pair<std::string, std::string>> versions();

struct StatusDeps {
  const Leases& leases;
  const CameraActor& camera;
  const SlmLoop& slm;
  const SensorKeeper& keeper;
  const WavefrontSearch& search;
  const ImagePublisher& images;
  const ClosedLoop& loop;
  const LiveRefiner& refiner;
  const Recorder& recorder;
  const Jobs& jobs;
  Pipeline& pipeline;
  LatencyHistogram& published_latency;
  Counters& counters;
  Events& events;
  const Library& library;
  StreamQueue& queue;
  ThreadPlan& threads;
  Reloader& reloader;
  ClientGuard& clients;
  /// Ends the process after a stop request while the display blocks the main thread. Returns only
  /// if the main thread has begun to stop by itself.
  std::function<void()> end_without_display;
};

/// Agent of the status thread: publishes a status message every second, and at once after a change.
class StatusReporter : public Agent {
 public:
  explicit StatusReporter(StatusDeps deps);

  bool do_work() override;
  /// Current status; rates and latencies are those of the last periodic measurement. Thread-safe.
  StatusMessage current() const;

 private:
  struct Measured {
    std::int64_t t_begin_ns = 0;  ///< of the second that was measured
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
  std::int64_t next_feed_ns_ = 0;
  std::set<const ThreadRow*> hung_;  ///< threads already reported as hung
  Marks marks_;
  Guarded<Measured> measured_;
};

}  // namespace ovws
