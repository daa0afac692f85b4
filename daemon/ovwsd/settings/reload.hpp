/// Configuration reload (SIGHUP): reads the configuration file and the saved values again, and
/// applies what can change at run time.
#pragma once

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/lease/leases.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/config_difference.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

struct ReloadDeps {
  const Config& config;           ///< configuration at the daemon's start
  Guarded<LoadedConfig>& loaded;  ///< last loaded; an applied reload replaces it
  Leases& leases;
  CameraActor& camera;
  SlmLoop& slm;
  SensorKeeper& keeper;
  LiveRefiner& refiner;
  ImagePublisher& images;
  Events& events;
  Disk& disk;
};

/// Applies one reload at a time, completely or not at all. Changes SLM, camera, then sensor, as the
/// methods of the control socket do; refinement (an error is a warning), image rate and log follow.
/// If one of the first three refuses, the earlier changes are rolled back. A reload reads the file
/// first. Then, from before it reads what is in use until all is changed, it has a lease of the
/// bench, so it never undoes a client's change. Keys that need a restart are reported, but not
/// applied. An event of kind `config` reports the outcome.
class Reloader {
 public:
  explicit Reloader(ReloadDeps deps) : deps_(std::move(deps)) {}

  /// Requests a reload. Async-signal-safe.
  void request() { requested_.store(true); }
  /// Starts a requested reload in the disk thread without waiting for its end. Status thread.
  void poll();

 private:
  /// One reload. Every step keeps a pointer to it, and when the last one is gone, the reload ends,
  /// and an event says how: at first, that a step threw or was dropped.
  struct Outcome {
    explicit Outcome(Reloader& of) : reloader(of) {}
    ~Outcome() { reloader.end(*this); }
    Outcome(const Outcome&) = delete;
    Outcome& operator=(const Outcome&) = delete;
    void say(Severity how_bad, std::string what, nlohmann::json with) {
      severity = how_bad;
      text = std::move(what);
      data = std::move(with);
    }

    Reloader& reloader;
    LeasePtr lease;  ///< from `begin` on, until all is changed
    Severity severity = Severity::error;
    std::string text =
        "configuration not reloaded: a step of the reload did not end; see the events for the "
        "cause, check the settings in use, and reload again";
    nlohmann::json data{{"reloaded", false}, {"field", ""}, {"reason", "a step did not end"}};
  };
  using Turn = std::shared_ptr<Outcome>;
  struct Reload {
    Turn turn;
    Config before, after;  ///< camera settings as requested, not as read back
    ConfigDifference keys;
    LoadedConfig read;
    bool had_camera = false;            ///< a camera was connected before
    std::optional<Error> refine_error;  ///< why the refinement does not use its settings
  };
  /// Why the configuration was not applied, and which parts could not be restored.
  struct Refusal {
    Refusal(Error error) : why(std::move(error)) {}
    void add(const char* part, const std::string& reason);
    Error why;
    std::vector<std::string> not_restored;
  };

  void read(const Turn& turn);
  void change(const Turn& turn, const LoadedConfig& read);
  void change_slm(const Reload& reload);
  void select_camera(const Reload& reload);
  void change_camera(const Reload& reload);
  void change_sensor(const Reload& reload);
  void finish(const Reload& reload);
  static void report(const Reload& reload);
  void roll_back_camera(const Reload& reload, const Refusal& refusal);
  void roll_back_devices(const Reload& reload, const Refusal& refusal);
  void roll_back_slm(const Reload& reload, const Refusal& refusal);
  static void refuse(const Turn& turn, const Refusal& refusal);
  void end(Outcome& outcome);

  ReloadDeps deps_;
  std::atomic<bool> requested_{false};
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
  std::atomic<bool> busy_{false};
};

}  // namespace ovws
