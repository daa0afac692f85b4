/// The sensor's state: hologram, aberration, reference. It prepares what the frame path uses, and
/// is the only one to change it.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/sensor/calibration_shelf.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/operator_maker.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_archive.hpp"
#include "daemon/ovwsd/sensor/reference_templates.hpp"
#include "daemon/ovwsd/sensor/registration_archive.hpp"
#include "daemon/ovwsd/sensor/torn_spots.hpp"
#include "daemon/ovwsd/slm/slm_archive.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/requests.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

struct ReferenceSpots;

/// Draws a picture of the SLM's size.
using Painter = std::function<void(const HologramRenderer&, Image<std::uint8_t>&)>;

/// What a job shows: the sensor with these modes for an aberration, or what `paint` draws.
struct Exhibit {
  std::vector<Mode> aberration;
  Painter paint;       ///< none: the sensor
  SensorSet sensor{};  ///< what of it, and of its tracking, is otherwise from now on
};

/// What others may know of the sensor at any time.
struct SensorSnapshot {
  SensorConfig sensor;
  TrackingSettings tracking;
  TemplateReport templates;      ///< what of tracking.templates is in use
  OperatorReport mode_operator;  ///< of plan_id
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;  ///< shown on purpose, RMS-normalised waves
  std::vector<Mode> correction;  ///< subtracted from the hologram
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< of the plan
  OpticsConfig optics;             ///< in the camera's region: as configured, or as registered
  std::optional<Registration> registration;  ///< the one in force, in pixels of the camera's sensor
  std::uint64_t plan_id = 0;  ///< frames measured with this plan are of all that stands here
  int subapertures = 0;
  std::vector<int> modes_j;
  std::string layout_fault;  ///< why the camera cannot see the spots, or the tracker tell them
                             ///< apart; empty: nothing is known to be wrong
  std::vector<int> torn;  ///< spots that are followed by the shapes that the wavefront gives them
  std::optional<Reference> reference;              ///< the one in force
  std::shared_ptr<const Calibration> calibration;  ///< that belongs to all this; null: none
  std::shared_ptr<const SlmInForce> slm;           ///< LUT and flatness; never null
};

struct InstrumentDeps {
  Pipeline& pipeline;
  SlmLoop& slm;
  ReferenceCollector& collector;
  ReferencePictureTaker& pictures;
  OperatorMaker& operators;
  Jobs& jobs;
  Events& events;
  DaemonStore& store;
  /// Before frames are measured with it; in the prepare thread, but for the first.
  std::function<void(const MeasurementPlan&, const SensorSnapshot&)> on_plan;
  /// Prepare thread: a job began (true) or ended (false).
  std::function<void(bool)> on_job;
};

/// An agent of the prepare thread. Every change is asked for from any thread, carried out in the
/// prepare thread in order, whole or not at all, and answered there.
class Instrument : public Agent {
 public:
  using Changed = std::function<void(Result<SensorSnapshot>)>;

  /// Errors: the configuration's lattice, LUT or flatness file cannot be used.
  static Result<std::unique_ptr<Instrument>> make(const Config& config, const InstrumentDeps& deps);

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

  void change_sensor(SensorSet change, Changed done);
  void set_aberration(std::vector<Mode> modes, Changed done);
  void set_correction(std::vector<Mode> modes, Changed done);
  /// The loop steers by what is in force now: until end_loop only the aberration, the camera, and
  /// the correction by `correct` change. Errc::refused if there is nothing to steer by.
  void begin_loop(Changed done);
  void end_loop();
  /// set_correction for the closed loop.
  void correct(std::vector<Mode> modes, Changed done);
  void show(HologramKind pattern, Changed done);
  /// Starts a job that averages settled frames; `done` gets its number. Errc::refused (field
  /// "allow_aberration"): an aberration is introduced, which the reference would hold.
  void take_reference(ReferenceTake take, std::function<void(Result<int>)> done);
  /// On the disk, too; an error if it cannot be removed there, and then nothing has changed.
  void clear_reference(Changed done);
  /// From now on where spots are expected, and how far they move, is as configured.
  void clear_registration(Changed done);

  /// Modes are read otherwise from now on; it is gone from the disk, too. An error if it cannot be
  /// removed there, and then nothing has changed.
  void clear_calibration(Changed done);

  /// From now on the look-up table, or the flatness, is the configured one, on the disk, too. An
  /// error if it cannot be removed there, or if one is in force and there is no display; then
  /// nothing has changed.
  void clear_lut(Changed done);
  void clear_flatness(Changed done);

  /// For jobs that show pictures. Prepare thread: whether neither a job nor the loop has the
  /// sensor.
  Result<void> check_free() const;
  /// Prepare thread: the sensor, which is free, belongs to this job; every other change is refused.
  void lend(int job);
  /// Any thread, for the job that has the sensor: its aberration and pattern change as by
  /// change_sensor, set_aberration and show.
  void exhibit(int job, Exhibit exhibit, Changed done);
  /// Any thread, for the job that has the sensor: where spots are expected, and how far they move,
  /// is as measured.
  void use_registration(int job, const Registration& registration, Changed done);
  /// Any thread, for the job that has the sensor and shows the sensor without a push: modes are
  /// read with what it measured from now on. Errc::refused if the sensor or its image is no longer
  /// that of `sensor_epoch`, when the job began.
  void use_calibration(int job, std::uint64_t sensor_epoch, MeasuredCalibration measured,
                       Changed done);
  /// Any thread, for the job that has the sensor: what it measured of the SLM is in force from now
  /// on, and kept. A flatness not if the sensor or its image is no longer that of `sensor_epoch`:
  /// Errc::refused.
  void use_lut(int job, MeasuredLut lut, Changed done);
  void use_flatness(int job, std::uint64_t sensor_epoch, MeasuredFlatness flatness, Changed done);
  /// Any thread: what was shown before the sensor was lent is shown again, as soon as there is a
  /// display; the sensor is free. `then` is called in the prepare thread, or destroyed if that has
  /// ended.
  void give_back(int job, std::function<void()> then);
  /// Positions count from where the registration, or else the configuration, says that spots are,
  /// from now on.
  void use_model_reference(Changed done);
  /// Frames of plan `plan_id` were found to have torn spots, or (none) not to: from now on they are
  /// followed as such. Nothing happens if another plan is in use by then, or while a job has
  /// the sensor. Any change of the sensor ends it.
  void follow(std::uint64_t plan_id, std::optional<TornSpots> torn);
  /// What the camera uses now, and which it is. If its image changed, frames are measured with a
  /// plan made for it from then on; a reference that is being taken ends with any change, one of
  /// another camera is not used.
  void camera_changed(const CameraSettings& camera, const std::optional<CameraInfo>& info);
  /// Prepare thread, for a reload of the configuration: until end_reload every change of others,
  /// and every job, is refused. Errc::refused if the sensor is not free.
  Result<void> begin_reload();
  /// change_sensor for the reload that has begun.
  void reload_sensor(SensorSet change, Changed done);
  /// Any thread. `then` is called in the prepare thread when the sensor is free.
  void end_reload(std::function<void()> then);
  /// Calls `then` in the prepare thread when every change asked for so far was carried out.
  void after_changes(std::function<void()> then) { mailbox_.post(std::move(then)); }

  SensorSnapshot snapshot() const { return snapshot_.get(); }

  /// Any thread. Errc::refused (field pixel_format) if the spots are too small for the lit pixels
  /// of a colour camera.
  Result<void> can_measure(PixelFormat format) const;

 private:
  /// All that decides what is shown and how a frame is measured.
  struct State {
    SensorConfig sensor;
    TrackingSettings tracking;
    HologramKind pattern = HologramKind::sensor;
    std::vector<Mode> aberration;
    std::vector<Mode> correction;
    Roi roi;
    PixelFormat format = PixelFormat::mono8;
    std::uint64_t sensor_epoch = 1;
    std::shared_ptr<const HologramRenderer> renderer;
    std::shared_ptr<const Image<std::uint8_t>> painted;  ///< of pattern `test`
    std::optional<Registration> registration;            ///< in pixels of the camera's sensor
    std::shared_ptr<const SlmInForce> slm;               ///< never null
  };
  /// The job that has the sensor, and what to go back to.
  struct Lease {
    int job = 0;
    SensorConfig sensor;
    TrackingSettings tracking;
    HologramKind pattern = HologramKind::sensor;
    std::vector<Mode> aberration;
  };

  Instrument(const Config& config, const InstrumentDeps& deps, HologramConfig hologram,
             State state);
  Result<SensorSnapshot> change_to(State next);
  Result<void> check_not_held() const;
  Result<State> changed_state(const SensorSet& change) const;
  static Result<void> renew_renderer(State& state);
  Result<SensorSnapshot> carry_out(State next);
  void fall_back_to(State before);
  Result<State> lent_state(int job) const;
  Result<SensorSnapshot> change_registration(const std::optional<Registration>& registration);
  OpticsConfig optics_of(const State& state) const;
  std::optional<Registration> registration_of(const State& state) const;
  void check_registration();
  void check_flatness();
  static std::uint64_t shown_epoch(const State& state);
  static std::vector<Mode> shown_modes(const State& state);
  HologramRequest render(const State& state);
  /// With the split spots of the plan in use.
  Result<std::unique_ptr<MeasurementPlan>> plan_for(const State& state, std::uint64_t hologram_id);
  Result<std::unique_ptr<MeasurementPlan>> plan_for(const State& state, std::uint64_t hologram_id,
                                                    const TornSpots* torn);
  void adopt(State state, std::unique_ptr<MeasurementPlan> plan);
  void judge_layout();
  void tell_torn(const std::vector<int>& before, const std::vector<int>& now);
  const ModeOperator* operator_for(const State& state) const;
  OperatorReport report_operator(const MeasurementPlan& plan);
  CalibrationKey calibration_key(const State& state) const;
  Result<void> check_operator(const SensorSet& change, const State& next) const;
  void adopt_calibration(int job, std::uint64_t sensor_epoch, MeasuredCalibration measured,
                         Changed done);
  Result<SensorSnapshot> change_slm(std::shared_ptr<const SlmInForce> slm);
  void clear_slm(const std::shared_ptr<const SlmInForce>& cleared,
                 void (SlmArchive::*drop)(DaemonStore::Dropped), Changed done);
  void load_for_slm();
  void force_slm(std::shared_ptr<const SlmInForce> slm);
  template <class T>
  std::function<void(const std::string&)> know_file_of(const T& measured,
                                                       std::shared_ptr<const T> SlmInForce::*part);
  nlohmann::json origin_of_slm() const;
  void keep(const OperatorKey& key, Result<ModeOperator> made);
  void tell_operator(OperatorKind before, OperatorKind now);
  void retire_plans();
  std::vector<Vec2> model_positions(const State& state) const;
  bool is_for(const Reference& reference, const State& state) const;
  bool is_at_its_place(const Reference& reference, const State& state) const;
  const Reference* find_reference(const State& state) const;
  std::optional<Reference> reference_for(const State& state) const;
  const OwnTemplates& templates_for(const State& state, const std::optional<Reference>& reference);
  void finish_reference(int job, const ReferenceCollector::Average& average);
  void end_reference(int job, const ReferenceCollector::Average& average,
                     const ReferenceSpots& spots, double introduced_rms_waves);
  Reference new_reference(ReferenceSource source) const;
  bool know_camera(const std::optional<CameraInfo>& info);
  void tell_stale();
  void warn_of_introduced(double rms_waves);
  void limit_pictures();
  void keep_reference(Reference reference, Changed done);
  void know_reference_file(const Reference& kept, const std::string& sha256);
  /// For the disk thread, when something was tried: `know` if it is kept, with its checksum, and
  /// once `done`; both in the prepare thread.
  std::function<void(const std::string&)> when_tried(std::function<void(const std::string&)> know,
                                                     Changed done);
  /// For the disk thread, when a file is gone, which `changed` is without; or else is still there:
  /// then `put_back` makes the change undone, unless the sensor is no longer free.
  DaemonStore::Dropped when_dropped(SensorSnapshot changed, std::function<void()> put_back,
                                    Changed done);
  Result<SensorSnapshot> change_reference(std::optional<Reference> reference);
  void fail_reference(const Error& why);
  void end_reference_job();
  void watch_reference_job();

  OpticsConfig optics_;
  SlmGeometry slm_geometry_;
  int workers_;
  InstrumentDeps deps_;
  HologramConfig hologram_;  ///< with LUT and flatness as configured
  ReferenceArchive archive_;
  RegistrationArchive registrations_;
  SlmArchive slm_archive_;
  State state_;
  Mailbox mailbox_;
  std::uint64_t next_hologram_id_ = 1;
  std::uint64_t next_plan_id_ = 1;
  std::uint64_t shown_hologram_id_ = 0;
  std::shared_ptr<const Image<std::uint8_t>> grey_;  ///< the picture of that number
  std::vector<Reference> references_;                ///< one a key
  TemplateShelf templates_;                          ///< of the reference in force
  OperatorShelf operators_;                          ///< diffractive ones
  CalibrationShelf calibrations_;
  std::list<std::unique_ptr<MeasurementPlan>> plans_;  ///< oldest first; the last is in use
  std::optional<CameraSettings> camera_;               ///< as last told
  std::optional<CameraInfo> camera_info_;              ///< the same
  std::vector<std::string> stale_told_;                ///< fields, by the last event
  /// All that decides where spots fall, and who finds them.
  using LayoutKey =
      std::tuple<SensorConfig, TrackerKind, std::optional<PxPerCycle>, std::optional<Vec2>, Roi>;
  std::optional<LayoutKey> layout_key_;  ///< of layout_fault_
  std::string layout_fault_;
  std::optional<TornSpots> torn_;     ///< of the plan in use
  std::optional<int> reference_job_;  ///< the job's number
  std::optional<Lease> lease_;
  bool looping_ = false;    ///< the loop is closed
  bool reloading_ = false;  ///< begin_reload, until end_reload
  Guarded<SensorSnapshot> snapshot_;
};

}  // namespace ovws
