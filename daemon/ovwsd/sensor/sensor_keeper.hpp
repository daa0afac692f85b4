/// The sensor's keeper: the only one to change it. It prepares what the frame path uses, shows it,
/// and tells what is in force.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/sensor/hold.hpp"
#include "daemon/ovwsd/sensor/operator_maker.hpp"
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
  OperatorMaker& operators;
  Events& events;
  DaemonStore& store;
  /// Before frames are measured with it; in the prepare thread, but for the first.
  std::function<void(const MeasurementPlan&, SensorView)> on_plan;
};

/// The agent of the prepare thread.
class SensorKeeper : public Agent {
 public:
  using Done = std::function<void(Result<SensorView>)>;

  /// With what the disk holds of this bench. Errors: the configuration's lattice, LUT or flatness
  /// file cannot be used.
  static Result<std::unique_ptr<SensorKeeper>> make(const Config& config,
                                                    const SensorKeeperDeps& deps);

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

  SensorView snapshot() const { return snapshot_.get(); }

  // Any thread. What is asked for is carried out in the prepare thread in order, and answered
  // there.

  /// Whole or not at all. `active` is called when the change is in force, unless it cannot be;
  /// `done` then, or when the disk has answered for its files. Errors: those of may_change and of
  /// the change; the display does not take the picture; there is no plan for it.
  void edit(Hold as, SensorChange change, Done done, std::function<void()> active = nullptr);
  /// Calls `then` when every change asked for so far was carried out.
  void after_changes(std::function<void()> then) { mailbox_.post(std::move(then)); }
  /// Releases the hold of `by`. After a job the previous hologram and settings are restored, as
  /// soon as there is a display.
  void release(Hold by, std::function<void()> then);
  /// What the camera uses now, and which it is. If its image changed, frames are measured with a
  /// plan made for it from then on; what belongs to another camera is not used.
  void camera_changed(const CameraSettings& camera, const std::optional<CameraInfo>& info);
  /// Frames of plan `plan_id` were found to have split spots, or (none) not to: from now on they
  /// are followed as such. Nothing happens if another plan is in use by then, or while a job has
  /// the sensor. Any change of the sensor ends it.
  void follow(std::uint64_t plan_id, std::optional<TornSpots> torn);

  // The prepare thread.

  /// Errc::refused, and what to wait for, if somebody holds it.
  Result<void> may_hold() const { return may_change(hold_, Hold::of_nobody()); }
  /// From now on only `by` changes it, until `release`. It is free.
  void hold(Hold by);

 private:
  SensorKeeper(const Config& config, const SensorKeeperDeps& deps, HologramConfig hologram);
  Result<void> begin();
  /// The display must take it; or may take it when there is one.
  enum class Show { now, when_possible };
  Result<void> activate(SensorEdit edit, Show show);
  Result<void> present(const SensorState& next, std::uint64_t hologram_id, Show show);
  void adopt(SensorEdit edit, const Bound& bound, std::unique_ptr<MeasurementPlan> plan);
  bool load_for_slm(const SlmInForce& slm, Knowledge& knowledge);
  OperatorReport report_operator(const MeasurementPlan& plan);
  void store_operator(const OperatorKey& key, Result<ModeOperator> made);
  void restore_lease();
  void discard_for_camera(const std::optional<CameraInfo>& info);
  void update_files(SensorEdit edit, SensorView changed, Done done);
  void undo(SensorEdit& edit, Error why, const Done& done);
  void set_checksum(SensorEdit& edit, const std::string& sha256);
  SensorEdit new_edit() { return {state_, knowledge_, lease_, bench_}; }

  SensorKeeperDeps deps_;
  SensorBench bench_;
  SensorState state_;
  Knowledge knowledge_;
  Plans plans_;
  SensorEvents events_;
  Hold hold_;
  std::optional<Lease> lease_;  ///< of the job that holds it
  Mailbox mailbox_;
  std::uint64_t next_hologram_id_ = 1;
  Guarded<SensorView> snapshot_;
};

/// Errc::refused (field pixel_format) if the spots are too small for the lit pixels of a colour
/// camera.
Result<void> can_measure(const SensorSnapshot& sensor, const SlmGeometry& slm, PixelFormat format);

}  // namespace ovws
