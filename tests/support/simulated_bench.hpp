/// Simulated bench in one process, without X server, camera or sockets: the daemon's actors on a
/// display and a camera that are connected by the twin's optics. Its open_display and open_camera
/// replace those of the driver table at link time.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "daemon/ovwsd/library/library.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::test {

/// The simulated optics between display and camera; shared by both. Thread-safe.
class SimulatedOptics {
 public:
  explicit SimulatedOptics(const twin::Config& config);
  ~SimulatedOptics();

  void show(const Image<std::uint8_t>& grey);
  /// The display's thread calls `call` before it shows a picture; none: nothing. Returns when the
  /// previous one is not running any more.
  void before_show(std::function<void()> call);
  /// The camera's thread calls `call` before it applies settings; none: nothing.
  void before_apply(std::function<void()> call);
  void apply();
  void set_truth(const twin::Truth& truth);
  twin::Truth truth() const;
  /// Exposes a frame of the hologram that is shown at its begin, which it returns: CLOCK_MONOTONIC
  /// ns.
  std::int64_t expose(const CameraSettings& settings, Image<std::uint16_t>& dn);

 private:
  struct Model;
  mutable std::mutex mutex_;
  std::unique_ptr<Model> model_;
  std::mutex call_mutex_;
  std::function<void()> before_show_, before_apply_;
};

/// Configurations of a bench that is fast to simulate: 7 subapertures on an SLM of 320 x 192.
Config small_daemon_config();
twin::Config small_twin_config();

/// One instance per process at a time. Its threads run from construction to destruction.
class SimulatedBench {
 public:
  /// Returns when frames of the first hologram are measured; the test fails if none is in a minute.
  explicit SimulatedBench(Config daemon = small_daemon_config(),
                          const twin::Config& twin = small_twin_config());
  ~SimulatedBench();

  /// Runs a procedure like the daemon and returns when the sensor is free again. Errors: the
  /// procedure's own; Errc::unavailable after a minute.
  Result<nlohmann::json> run(const std::string& kind, Procedure procedure,
                             Request request = Request::run_job);
  /// Cancels the procedure that runs. Any thread.
  void cancel() { (void)jobs_.cancel(job_); }
  /// Changes the sensor as a client does, and returns when the change is active. Errors: those of
  /// the lease, too.
  Result<SensorView> edit(SensorChange change);
  /// The mean coefficients, waves, of the next `frames` settled and valid frames of the current
  /// hologram; empty if they do not arrive within a minute.
  std::vector<double> mean_waves(int frames);

  SensorView sensor() const { return keeper_->snapshot(); }
  CameraSnapshot camera() const { return camera_->snapshot(); }
  CameraActor& camera_actor() { return *camera_; }
  SimulatedOptics& optics() { return optics_; }
  SensorKeeper& keeper() { return *keeper_; }
  Procedures& procedures() { return *procedures_; }
  FrameTaps& frames() { return frames_; }
  Events& events() { return events_; }
  Leases& leases() { return leases_; }
  SlmLoop& slm() { return slm_; }
  const Config& config() const { return config_; }

 private:
  class Publish;   ///< stands for the publish and images threads
  class Display;   ///< closes the SLM's loop when it ends
  struct Turning;  ///< a thread that runs an agent
  void start(Agent& agent);

  std::string folder_;
  Config config_;
  SimulatedOptics optics_;
  Counters counters_;
  StreamQueue queue_;
  Events events_{queue_};
  Leases leases_{events_, false};
  Library library_;
  LatestValue<ShownHologram> shown_;
  LatestValue<AppliedSettings> settings_;
  Pipeline pipeline_;
  FrameTaps frames_;
  Jobs jobs_{events_};
  SlmLoop slm_;
  std::unique_ptr<CameraActor> camera_;
  std::unique_ptr<SensorKeeper> keeper_;
  std::unique_ptr<Procedures> procedures_;
  std::atomic<int> job_{0};  ///< the last one that was started
  std::vector<std::unique_ptr<Agent>> own_agents_;
  std::vector<std::unique_ptr<Turning>> threads_;  ///< in start order; ended in reverse order
};

}  // namespace ovws::test
