/// Configuration reload (SIGHUP): reads the configuration file and the saved values again, and
/// applies what can change at run time.
#pragma once

#include <atomic>
#include <string>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/state_keeper.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/config_difference.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

struct ReloadDeps {
  const Config& config;           ///< as the daemon was started with
  Guarded<LoadedConfig>& loaded;  ///< as last loaded; a reload that is applied replaces it
  const StateKeeper& state;
  CameraActor& camera;
  SensorKeeper& keeper;
  LiveRefiner& refiner;
  ImagePublisher& images;
  Events& events;
  Disk& disk;
};

/// One reload at a time, all or nothing: camera, refinement, then sensor, each as by its method of
/// the control socket. If a part refuses, the earlier changes are rolled back. Meanwhile no job
/// starts and nothing else changes the sensor. Keys that need a restart are reported, and not
/// applied. The outcome is an event of kind `config`.
class Reloader {
 public:
  explicit Reloader(ReloadDeps deps) : deps_(std::move(deps)) {}

  /// Async-signal-safe.
  void request() { requested_.store(true); }
  /// Status thread: starts a requested reload in the prepare thread, and does not wait for it.
  void poll();

 private:
  struct Reload {
    Config before, after;  ///< the camera's settings as asked for, not as read back
    ConfigDifference keys;
    LoadedConfig read;
  };

  void begin();
  void change(const LoadedConfig& read);
  void change_camera(const Reload& reload);
  void change_refine(const Reload& reload);
  void change_sensor(const Reload& reload);
  void roll_back(const Reload& reload, const Error& why);
  void finish(const Reload& reload);
  void report(const Reload& reload);
  void roll_back_camera(const Reload& reload, const Error& why);
  void refuse(const Error& why, const char* what_stays = "nothing has changed");
  void end(Severity severity, std::string text, nlohmann::json data);

  ReloadDeps deps_;
  std::atomic<bool> requested_{false};
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
  std::atomic<bool> busy_{false};
};

}  // namespace ovws
