/// A whole bench in one process, without X server, camera or sockets: the daemon's own actors on a
/// display and a camera behind which the twin's optics are. A program that links it has its
/// open_display and open_camera instead of the driver table's.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/frames/frame_broker.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/operator_maker.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::test {

/// What is between the display and the camera; shared by both.
class SimulatedOptics {
 public:
  explicit SimulatedOptics(const twin::Config& config);
  ~SimulatedOptics();

  // Any thread.
  void show(const Image<std::uint8_t>& grey);
  void set_truth(const twin::Truth& truth);
  twin::Truth truth() const;
  /// A frame of what is shown now.
  void expose(const CameraSettings& settings, Image<std::uint16_t>& dn);

 private:
  struct Model;
  mutable std::mutex mutex_;
  std::unique_ptr<Model> model_;
};

/// The configurations of a bench that is quick to simulate: 7 subapertures on an SLM of 320 x 192.
Config small_daemon_config();
twin::Config small_twin_config();

/// One at a time in a process. All threads run from the constructor to the destructor.
class SimulatedBench {
 public:
  explicit SimulatedBench(Config daemon = small_daemon_config(),
                          const twin::Config& twin = small_twin_config());
  ~SimulatedBench();

  /// Waits until frames of the first hologram are measured; false if none comes within 10 s.
  bool is_running();
  /// Carries out a procedure as the daemon does, and returns when the sensor is free again. Errors:
  /// the procedure's own; Errc::unavailable after a minute.
  Result<nlohmann::json> run(const std::string& kind, Procedure procedure);
  /// Changes the sensor, and returns when the change is active.
  Result<SensorView> edit(SensorChange change);
  /// The mean coefficients of the next `frames` settled and valid frames of what the sensor shows;
  /// empty if they do not come within 10 s.
  std::vector<double> mean_waves(int frames);

  SensorView sensor() const { return keeper_->snapshot(); }
  CameraSnapshot camera() const { return camera_->snapshot(); }
  SimulatedOptics& optics() { return optics_; }
  const Config& config() const { return config_; }

 private:
  class Publish;   ///< plays the publish and the images thread
  class Display;   ///< closes the SLM's loop when it ends
  struct Turning;  ///< a thread that turns an agent
  void start(Agent& agent);

  std::string folder_;
  Config config_;
  SimulatedOptics optics_;
  Counters counters_;
  StreamQueue queue_;
  Events events_{queue_};
  DaemonStore store_;
  LatestValue<ShownHologram> shown_;
  LatestValue<AppliedSettings> settings_;
  Pipeline pipeline_;
  FrameBroker frames_;
  OperatorMaker operators_;
  Jobs jobs_{events_};
  SlmLoop slm_;
  std::unique_ptr<CameraActor> camera_;
  std::unique_ptr<SensorKeeper> keeper_;
  std::unique_ptr<Procedures> procedures_;
  std::vector<std::unique_ptr<Agent>> own_agents_;
  std::vector<std::unique_ptr<Turning>> threads_;  ///< in the order in which they end
};

}  // namespace ovws::test
