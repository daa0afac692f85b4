/// Configuration reload (SIGHUP): reads the configuration file and the saved values again, and
/// applies what can change at run time.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/fitter/live_refiner.hpp"
#include "daemon/ovwsd/lease/leases.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/settings.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/ovwsd/streams/image_publisher.hpp"

namespace ovws {

struct ReloadDeps {
  Settings& settings;
  Leases& leases;
  CameraActor& camera;
  SlmLoop& slm;
  SensorKeeper& keeper;
  LiveRefiner& refiner;
  ImagePublisher& images;
  Events& events;
  Disk& disk;
  std::atomic<bool>& requested;  ///< a signal handler sets it
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

  /// Starts a requested reload, once the daemon has started, in the disk thread without waiting for
  /// its end. Status thread.
  void poll();

 private:
  /// One reload. Every step keeps a pointer to it, and when the last one is gone, the reload ends,
  /// and an event says how: at first, that a step threw or was dropped.
  struct Reload {
    explicit Reload(Reloader& of) : reloader(of) {}
    ~Reload() { reloader.end(*this); }
    Reload(const Reload&) = delete;
    Reload& operator=(const Reload&) = delete;
    void say(Severity how_bad, std::string what, nlohmann::json with) {
      severity = how_bad;
      text = std::move(what);
      data = std::move(with);
    }

    Reloader& reloader;
    LeasePtr lease;        ///< from `begin` on, until all is changed
    LoadedConfig read;     ///< from the files
    int saves = 0;         ///< Settings::saves before it was read
    Config before, after;  ///< camera settings as requested, not as read back
    ConfigDifference keys;
    bool had_camera = false;                ///< a camera was connected before
    std::optional<Error> why_not;           ///< why it is rolled back
    std::vector<std::string> not_restored;  ///< parts that could not be rolled back
    std::optional<Error> refine_error;      ///< why the refinement does not use its settings
    Severity severity = Severity::error;
    std::string text =
        "configuration not reloaded: a step of the reload did not end; see the events for the "
        "cause, check the settings in use, and reload again";
    nlohmann::json data{{"reloaded", false}, {"field", ""}, {"reason", "a step did not end"}};
  };
  using ReloadPtr = std::shared_ptr<Reload>;
  using Done = std::function<void(const Result<void>&)>;
  /// A part of the daemon that may refuse its settings. `apply` makes it use those of `to`, unless
  /// it does already.
  struct Part {
    const char* section;  ///< of the configuration
    const char* name;
    void (Reloader::*apply)(const ReloadPtr& reload, const Config& to, const Done& done);
  };
  static const std::array<Part, 3> kParts;

  void post_read(const ReloadPtr& reload);
  void read(const ReloadPtr& reload);
  void change(const ReloadPtr& reload);
  void apply_from(const ReloadPtr& reload, std::size_t part);
  void roll_back(const ReloadPtr& reload, std::size_t parts);
  void apply_slm(const ReloadPtr& reload, const Config& to, const Done& done);
  void apply_camera(const ReloadPtr& reload, const Config& to, const Done& done);
  void apply_sensor(const ReloadPtr& reload, const Config& to, const Done& done);
  void finish(const ReloadPtr& reload);
  static void report(Reload& reload);
  static void refuse(Reload& reload);
  void end(Reload& reload);

  ReloadDeps deps_;
  std::atomic<bool> busy_{false};
};

}  // namespace ovws
