/// SensorKeeper owns the sensor's state: it applies changes, shows holograms, activates measurement
/// plans and publishes snapshots.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "config/config.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/actor/time_share.hpp"
#include "daemon/ovwsd/lease/leases.hpp"
#include "daemon/ovwsd/sensor/plans.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "daemon/ovwsd/sensor/sensor_events.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

struct SensorKeeperDeps {
  Pipeline& pipeline;
  SlmLoop& slm;
  Events& events;
  Library& library;
  Leases& leases;
  /// Called before a plan becomes active, in the prepare thread. For the first plan it is called in
  /// the thread that calls SensorKeeper::make.
  std::function<void(const MeasurementPlan&, SensorView)> on_plan;
};

/// Agent of the prepare thread. All changes of the sensor are made in this thread.
class SensorKeeper : public Agent {
 public:
  using Done = std::function<void(Result<SensorView>)>;

  /// Loads the stored measurements of this bench and activates the first plan. Errors: the
  /// configured lattice, LUT file or flatness file cannot be used.
  static Result<std::unique_ptr<SensorKeeper>> make(const Config& config,
                                                    const SensorKeeperDeps& deps);

  bool do_work() override;
  void on_close() override {
    mailbox_.close();
    questions_.clear();  // their callers get the answer of a daemon that stops
  }

  SensorView snapshot() const { return snapshot_.get(); }
  /// Who has the sensor for longer than a change. Any thread. While a job has it, it takes no
  /// templates; with another tracker than `fit`, it takes them only while the loop has it.
  Holder holder() const { return holder_.load(); }

  // Any thread. Requests are carried out in order by the prepare thread, which also calls the
  // callbacks.

  /// Applies a change completely, or not at all; the caller has a lease of what it changes.
  /// `active` is called once the change is active, and not on an error. `done` is called when the
  /// change's files have been written or removed, too, or at once if it has no files. Errors: those
  /// of the change; the SLM cannot sample the hologram; no plan can be built; the display does not
  /// take the hologram.
  void edit(SensorChange change, Done done, std::function<void()> active = nullptr);
  /// Calls `question` with the present state, after all changes requested so far. It changes
  /// nothing.
  void ask(std::function<void(const SensorEdit&)> question);
  /// The same for requests that clients with the role `read` may repeat at will: these calls have a
  /// tenth of the thread's time (TimeShare), so that they do not slow a closed loop.
  void ask_in_spare_time(std::function<void(const SensorEdit&)> question);
  /// Calls `then` when all changes requested so far have been carried out.
  void after_changes(std::function<void()> then) { mailbox_.post(std::move(then)); }
  /// See Leases::Turn. When a job's turn ends, restores the previous settings, and the previous
  /// hologram as soon as a display is connected.
  void take_turn(Holder holder, std::function<void()> then);
  /// Call when the camera's settings or identity have changed. If region or pixel format differ, a
  /// plan for the new image becomes active. Measurements made with another camera are not used.
  void camera_changed(const CameraSettings& camera, const std::optional<CameraInfo>& info);
  /// Builds a plan that measures frames with these templates. No effect if the sensor's epoch has
  /// changed, or if the sensor takes no templates (holder). Templates for another reference are not
  /// used.
  void use_templates(ActiveTemplates templates);

 private:
  SensorKeeper(const Config& config, const SensorKeeperDeps& deps, HologramConfig hologram);
  Result<void> begin();
  /// Whether the display must take a hologram now, or may take it once it is connected.
  enum class Show { now, when_possible };
  Result<void> activate(SensorEdit edit, Show show);
  Result<void> present(const SensorState& next, std::uint64_t hologram_id, Show show);
  void adopt(SensorEdit edit, const Bound& bound, std::unique_ptr<MeasurementPlan> plan);
  void adopt_without_plan(SensorEdit edit, const Error& why);
  void describe(SensorSnapshot& now, const Bound& bound);
  void load_slm(SensorState& state);
  void load_measured(SensorEdit& edit);
  bool use_waiting(SensorEdit& edit);
  void plan_again(SensorEdit edit);
  void publish_stale();
  void set_holder(Holder holder);
  void restore_from_before_job();
  void discard_for_camera(SensorEdit& edit);
  void update_files(const std::function<Library::Item()>& stored, RemovedItems removed, Done done);
  void undo(const RemovedItems& removed, Error why, const Done& done);
  SensorEdit new_edit() { return {state_, knowledge_, before_job_, bench_}; }

  SensorKeeperDeps deps_;
  SensorBench bench_;
  SensorState state_;
  Knowledge knowledge_;
  Plans plans_;
  SensorEvents events_;
  std::atomic<Holder> holder_{Holder::nobody};  ///< copy of state_.holder for other threads
  std::optional<SensorShown> before_job_;       ///< settings to restore when the job ends
  Mailbox mailbox_;
  std::deque<std::function<void(const SensorEdit&)>> questions_;  ///< of ask_in_spare_time
  TimeShare spare_time_;
  std::uint64_t next_hologram_id_ = 1;
  Guarded<SensorView> snapshot_;
};

/// Checks that the SLM shows the sensor. Errc::refused: it shows another pattern.
Result<void> check_shows_sensor(const SensorShown& sensor);
/// Errc::refused: a DMD shows a sequence of patterns.
Result<void> check_no_sequence(const SensorShown& sensor);
/// Both of these checks.
Result<void> check_shows_one_sensor(const SensorShown& sensor);

/// Checks that spots can be measured in this pixel format. Errc::refused (field "pixel_format"): of
/// a colour camera's pixels, too few per spot see the laser.
Result<void> can_measure(const SensorSnapshot& sensor, const SlmGeometry& slm, PixelFormat format);

}  // namespace ovws
