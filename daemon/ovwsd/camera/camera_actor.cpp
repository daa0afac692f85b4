#include "daemon/ovwsd/camera/camera_actor.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/printable.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/camera/camera_limits.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kRetryNs = 1'000'000'000;
// Frame timeout: a busy host or a busy camera may delay frames for more than a second.
constexpr double kPatienceS = 2.0;
constexpr double kFirstFramePatienceS = 5.0;
constexpr std::size_t kMaxFaultBytes = 1000;  // limit, because a reason may quote the camera
constexpr auto kMailboxWait = std::chrono::milliseconds(50);

/// Cause of unusable frames: its counter, and a text with the remedy.
struct Unusable {
  Counter counter;
  const char* text;
};
constexpr std::array<Unusable, 3> kUnusable{
    {{Counter::frames_incomplete,
      "every frame arrives incomplete, because packets are lost; check the cable, the switch and "
      "camera.packet_size_bytes"},
     {Counter::frames_duplicated,
      "it repeats earlier frames and sends no new ones; switch the camera off and on"},
     {Counter::frames_out_of_order,
      "every frame arrives out of order; check that the network has only one path to the camera"}}};

/// Removes "camera." from the error's field: drivers report configuration keys, but clients use the
/// names of params.
Error in_params(Error error) {
  constexpr std::string_view kSection = "camera.";
  if (error.field.starts_with(kSection)) error.field.erase(0, kSection.size());
  return error;
}

tl::unexpected<Error> not_connected(const CameraSnapshot& now) {
  return fail(Errc::unavailable, "camera", "no camera is connected: " + now.fault);
}

}  // namespace

CameraSet CameraSnapshot::undo_of(const CameraSet& change, CameraSet undo) const {
  for (const auto member :
       {&CameraSettings::exposure_us, &CameraSettings::gain_db, &CameraSettings::gain_raw}) {
    if (!change.gives(member) || undo.gives(member)) continue;
    undo.put(member, std::isnan(asked.*member) ? settings.*member : asked.*member);
  }
  return undo;
}

CameraActor::CameraActor(CameraConfig config, CameraActorDeps deps)
    : config_(std::move(config)),
      deps_(std::move(deps)),
      settings_(config_.settings),
      asked_(settings_) {
  snapshot_.set({false, {}, settings_, asked_, {}, "not opened yet", false, config_.id});
}

CameraActor::~CameraActor() = default;

bool CameraActor::do_work() {
  const bool worked = mailbox_.run_one(kMailboxWait);
  if (lost_) {
    close_camera();
  } else if (!camera_) {
    if (monotonic_ns() >= next_try_ns_) open_with({});
  } else if (!camera_->alive()) {
    lose({Errc::device, "camera",
          "control of the camera was lost: check its cable and power, and close other programs "
          "that use it"});
  } else {
    watch_frames();
  }
  return worked;
}

void CameraActor::on_close() {
  mailbox_.close();
  // Leak the camera if the frame path still holds pointers into it, so that no pointer dangles.
  if (camera_ && !close_camera()) (void)camera_.release();
}

void CameraActor::change(CameraSet change, Applied done) {
  // Reply in the caller's thread: a silent camera may block the camera thread for seconds.
  const CameraSnapshot now = snapshot_.get();
  if (!now.connected && !now.at_fault) return done(not_connected(now));
  if (change.gives(&CameraSettings::gain_db) && now.limits && now.limits->gain_raw)
    return done(fail(no_gain_in_db("gain_db", *now.limits)));
  mailbox_.post([this, change, done = std::move(done)] { carry_out(change, done); });
}

void CameraActor::change_or_keep(CameraSet change, Applied done) {
  mailbox_.post([this, change, done = std::move(done)] {
    if (camera_ || snapshot_.get().at_fault) return carry_out(change, done);
    keep_for_next(change);
    done(snapshot_.get());
  });
}

void CameraActor::keep_for_next(const CameraSet& change) {
  settings_ = change.applied_to(settings_);
  keep_asked(change);
  publish(snapshot_.get());
}

void CameraActor::select(std::string id, CameraSet change, bool wait, Applied done) {
  mailbox_.post([this, id = std::move(id), change = std::move(change), wait,
                 done = std::move(done)] { carry_out_selection(id, change, wait, done); });
}

void CameraActor::carry_out_selection(const std::string& id, const CameraSet& change, bool wait,
                                      const Applied& done) {
  if (id == config_.id && snapshot_.get().connected) return done(snapshot_.get());
  if (camera_ && !close_camera()) {
    return done(fail(Errc::unavailable, "camera",
                     "frames of the present camera are still in use; repeat the request"));
  }
  limits_.reset();
  const std::string before = std::exchange(config_.id, id);
  // The settings read back are rounded to what the former camera can do.
  const CameraSettings settings = std::exchange(settings_, asked_);
  open_with(change);
  const CameraSnapshot now = snapshot_.get();
  if (now.connected) return done(now);
  if (now.at_fault || wait) {
    keep_for_next(change);
    return done(snapshot_.get());
  }
  config_.id = before;
  settings_ = settings;
  open_with({});
  done(fail(Errc::unavailable, "camera.id", now.fault));
}

void CameraActor::restore(CameraSet before, std::function<void()> then) {
  mailbox_.post([this, before = std::move(before), then = std::move(then)] {
    carry_out(before, [this, &before](const Result<CameraSnapshot>& applied) {
      if (applied) return;
      settings_ = before.applied_to(settings_);  // applied at the next connection or camera.set
      keep_asked(before);
      if (camera_ && !lost_) {
        deps_.events.emit("camera", Severity::warning,
                          fmt::format("camera: the settings {} could not be restored: "
                                      "{}; set them with camera.set",
                                      before.given().dump(), applied.error().reason),
                          before.given());
      }
      publish(snapshot_.get());
    });
    then();
  });
}

void CameraActor::carry_out(const CameraSet& change, const Applied& done) {
  if (!camera_ && snapshot_.get().at_fault) return reopen(change, done);
  if (!camera_ || lost_) return done(not_connected(snapshot_.get()));
  const auto wanted = within_limits(change.applied_to(settings_), *limits_, change.clamp());
  if (!wanted) return done(fail(wanted.error()));
  if (const auto applied = apply(*wanted); !applied) {
    // The camera's settings are unknown: it was reset, or does not answer.
    if (camera_ && !lost_ && !camera_->alive()) lose(applied.error());
    if (!camera_ && !needs_intervention(applied.error())) return reopen(change, done);
    return done(fail(in_params(applied.error())));
  }
  keep_asked(change);
  refresh_limits();
  publish_connected();
  done(snapshot_.get());
}

/// Reopens the camera with the change, because it refused or lost its previous settings.
void CameraActor::reopen(const CameraSet& change, const Applied& done) {
  open_with(change);
  const CameraSnapshot now = snapshot_.get();
  if (now.connected) return done(now);
  if (!now.at_fault) return done(not_connected(now));
  done(
      fail(Errc::invalid, "camera", "the camera cannot be used with these settings: " + now.fault));
}

/// Opens the camera with `change` applied. settings_ changes only if the camera accepts the change.
void CameraActor::open_with(const CameraSet& change) {
  next_try_ns_ = monotonic_ns() + kRetryNs;
  auto opened = open_camera(config_);
  if (!opened) return publish_absent(opened.error());
  camera_ = std::move(*opened);
  auto limits = camera_->limits();
  if (!limits) return lose(limits.error());
  limits_ = *limits;
  const auto wanted = within_limits(change.applied_to(settings_), *limits_, change.clamp());
  if (!wanted) {
    return lose({wanted.error().code, "camera",
                 "camera." + wanted.error().field + ": " + wanted.error().reason});
  }
  if (const auto started = start_stream(*wanted); !started) return lose(started.error());
  keep_asked(change);
  refresh_limits();
  if (ever_connected_) deps_.counters.add(Counter::camera_reconnects);
  ever_connected_ = true;
  publish_connected();
  const CameraInfo& info = camera_->info();
  deps_.events.emit("camera", Severity::info,
                    fmt::format("camera {} {} ({}) at {} is connected", info.vendor, info.model,
                                info.serial, info.address));
}

/// Stores an accepted request in asked_; with `clamp`, clamps its values to the current limits.
void CameraActor::keep_asked(const CameraSet& change) {
  asked_ = change.applied_to(asked_);
  if (change.clamp() && limits_) asked_ = within_limits(asked_, *limits_, true).value_or(asked_);
}

/// Applies the settings, starts the stream, and attaches the camera to the frame path.
Result<void> CameraActor::start_stream(const CameraSettings& wanted) {
  const auto applied = camera_->apply(wanted);
  if (!applied) return fail(applied.error());
  if (auto started = camera_->start(); !started) return started;
  const std::int64_t now_ns = monotonic_ns();
  previous_frame_timeout_s_ = 0.0;
  settings_since_ns_ = now_ns;
  write_applied_settings(*applied, *applied, now_ns, now_ns);
  settings_ = *applied;
  attached_ns_ = monotonic_ns();
  unusable_before_ = count_unusable();
  return deps_.pipeline.attach(*camera_);
}

/// Disconnects the camera and publishes the fault, which no frame of this camera follows unless the
/// frame path keeps it for longer than detach() waits. do_work later reopens it as a new object.
void CameraActor::lose(const Error& why) {
  lost_ = true;
  limits_.reset();
  const bool detached = deps_.pipeline.detach().has_value();
  publish_absent(why);
  if (detached) destroy_camera();  // which takes seconds if the camera does not answer
}

/// Destroys the camera. Returns false if the frame path still holds its frames: try again later.
bool CameraActor::close_camera() {
  if (!deps_.pipeline.detach()) return false;
  destroy_camera();
  return true;
}

void CameraActor::destroy_camera() {
  camera_->stop();
  camera_.reset();
  lost_ = false;
}

/// Frame watchdog: disconnects a silent camera, which Aravis notices only after about 5 s, and
/// reports a camera whose frames are all unusable. A camera that has just stopped is not reported:
/// its last frame may have been cut off.
void CameraActor::watch_frames() {
  const double sign_s = silent_s(deps_.pipeline.last_sign_mono_ns());
  if (sign_s > frame_timeout_s()) {
    return lose(
        {Errc::device, "camera",
         config_.trigger.empty()
             ? "the camera sends no frames: check its cable and the firewall; run ovws doctor"
             : "the camera sends no frames: check that pulses come to its input " +
                   config_.trigger + " (camera.trigger), its cable and the firewall"});
  }
  const std::int64_t last_ns = deps_.pipeline.last_frame_mono_ns();
  if (last_ns != std::exchange(last_frame_ns_, last_ns)) unusable_before_ = count_unusable();
  const bool unusable = silent_s(last_ns) > frame_timeout_s();
  const bool sends = sign_s < 0.5 * frame_timeout_s();
  unusable_reported_ = unusable && (unusable_reported_ || (sends && report_unusable()));
}

CameraActor::UnusableFrames CameraActor::count_unusable() const {
  UnusableFrames counts{};
  for (std::size_t k = 0; k < counts.size(); ++k)
    counts[k] = deps_.counters.get(kUnusable[k].counter);
  return counts;
}

/// Emits an event with the most frequent cause of unusable frames since the last usable frame.
/// Returns false if no unusable frame came.
bool CameraActor::report_unusable() {
  UnusableFrames since = count_unusable();
  for (std::size_t k = 0; k < since.size(); ++k) since[k] -= unusable_before_[k];
  const auto most = std::max_element(since.begin(), since.end());
  if (*most == 0) return false;
  const Unusable& why = kUnusable[std::size_t(most - since.begin())];
  deps_.events.emit("camera", Severity::error, std::string("camera: ") + why.text,
                    {{"counter", counter_name(why.counter)}});
  return true;
}

/// Frame timeout, s: the longer of three frame periods and exposure plus patience (2 s; 5 s before
/// the first frame). Until the first frame after a change the camera may still use the previous
/// settings.
double CameraActor::frame_timeout_s() const {
  const std::int64_t last_ns = deps_.pipeline.last_sign_mono_ns();
  const double patience_s = last_ns > attached_ns_ ? kPatienceS : kFirstFramePatienceS;
  const double period_s = 1.0 / std::max(settings_.frame_rate_hz, 1e-3);
  const double now_s = std::max(3.0 * period_s, settings_.exposure_us * 1e-6 + patience_s);
  const bool changed = last_ns > settings_since_ns_;
  return changed ? now_s : std::max(now_s, previous_frame_timeout_s_);
}

/// Seconds since `last_ns`, or since the stream began if that is later.
double CameraActor::silent_s(std::int64_t last_ns) const {
  return 1e-9 * double(monotonic_ns() - std::max(attached_ns_, last_ns));
}

/// Reads the camera's limits again, because they depend on the settings: the maximum exposure on
/// the frame rate, and the frame rate on the region.
void CameraActor::refresh_limits() {
  if (auto limits = camera_->limits()) limits_ = *limits;
}

Result<CameraSettings> CameraActor::apply(const CameraSettings& wanted) {
  const bool same_image =
      wanted.roi == settings_.roi && wanted.pixel_format == settings_.pixel_format;
  return same_image ? apply_live(wanted) : apply_stopped(wanted);
}

Result<CameraSettings> CameraActor::apply_live(const CameraSettings& wanted) {
  const std::int64_t t_begin_ns = monotonic_ns();
  // A frame exposed during the register writes has neither the old nor the new settings.
  write_applied_settings(settings_, wanted, t_begin_ns, ShownHologram::kNever);
  auto applied = camera_->apply(wanted);
  // The settings of all frames stay unknown until the camera is open again.
  if (!applied && !camera_->alive()) return applied;
  const std::int64_t t_end_ns = monotonic_ns();
  write_applied_settings(settings_, applied.value_or(settings_), t_begin_ns, t_end_ns);
  previous_frame_timeout_s_ = frame_timeout_s();
  settings_since_ns_ = t_end_ns;
  if (!applied) return applied;
  settings_ = *applied;
  return applied;
}

/// Changes the image's size or format with the stream stopped. Restores the previous settings if
/// the camera refuses the change.
Result<CameraSettings> CameraActor::apply_stopped(const CameraSettings& wanted) {
  const CameraSettings before = settings_;
  if (auto detached = deps_.pipeline.detach(); !detached) {
    lose(detached.error());
    return fail(detached.error());
  }
  camera_->stop();
  const auto started = start_stream(wanted);
  if (started) return settings_;
  if (const auto detached = deps_.pipeline.detach(); !detached) {
    lose(detached.error());
    return fail(started.error());
  }
  camera_->stop();
  if (const auto back = start_stream(before); !back) lose(back.error());
  return fail(started.error());
}

void CameraActor::write_applied_settings(const CameraSettings& before, const CameraSettings& after,
                                         std::int64_t t_begin_ns, std::int64_t t_end_ns) {
  AppliedSettings applied;
  applied.gain_db = after.gain_db;
  applied.gain_raw = after.gain_raw;
  applied.exposure_us = after.exposure_us;
  applied.frame_rate_hz = after.frame_rate_hz;
  applied.previous_gain_db = before.gain_db;
  applied.previous_gain_raw = before.gain_raw;
  applied.previous_exposure_us = before.exposure_us;
  applied.roi = after.roi;
  applied.t_previous_end_mono_ns = settings_since_ns_;
  applied.t_write_begin_mono_ns = t_begin_ns;
  applied.t_write_end_mono_ns = t_end_ns;
  applied.transfer_ns = std::int64_t(config_.transfer_ms * 1e6);
  deps_.settings.write(applied);
}

void CameraActor::publish_connected() {
  CameraSnapshot now;
  now.connected = true;
  now.info = camera_->info();
  now.limits = limits_;
  publish(std::move(now));
}

void CameraActor::publish_absent(const Error& why) {
  CameraSnapshot now;
  now.fault = printable(why.reason, kMaxFaultBytes);
  now.at_fault = needs_intervention(why);
  publish(std::move(now));
}

/// Publishes the camera's state, and emits an event for a new fault.
void CameraActor::publish(CameraSnapshot now) {
  now.settings = settings_;
  now.asked = asked_;
  now.id = config_.id;
  now.triggered = !config_.trigger.empty();
  now.settings_since_ns = settings_since_ns_;
  const bool new_fault = !now.fault.empty() && now.fault != snapshot_.get().fault;
  snapshot_.change([&](CameraSnapshot& published) {
    deps_.on_change(now);
    published = now;
  });
  if (new_fault) deps_.events.emit("camera", Severity::error, "camera: " + now.fault);
  deps_.events.status_changed();
}

}  // namespace ovws
