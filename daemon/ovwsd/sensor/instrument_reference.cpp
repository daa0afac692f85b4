#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/sensor/instrument.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr double kSamePlace = 0.25;       // lambda/d
constexpr double kMostMotion = 0.05;      // lambda/d, while a reference is taken
constexpr std::size_t kMostPictures = 8;  // of the references taken last: some MiB each

Result<void> check_introduced(const ReferenceTake& take, const std::vector<Mode>& aberration) {
  const double introduced = rms_waves(aberration);
  if (take.allow_aberration || introduced == 0.0) return {};
  return fail(
      Errc::refused, "allow_aberration",
      fmt::format("the SLM shows an introduced aberration of {:.4f} wave RMS, which the reference "
                  "would make the zero of all coefficients: clear it first (aberration.clear), or "
                  "set \"allow_aberration\": true",
                  introduced));
}

void warn_of_lost(const ReferenceSpots& spots, Events& events) {
  if (spots.lost.empty()) return;
  std::string text = fmt::format(
      "the reference lacks spots {}, which were found in fewer than half of its frames: they are "
      "not used",
      listed_spots(spots.lost));
  if (!spots.weak_modes_j.empty()) {
    text += fmt::format("; the modes j = {} are noisier for it", listed_spots(spots.weak_modes_j));
  }
  events.emit("reference", Severity::warning, text,
              {{"lost_spots", spots.lost}, {"weak_modes", spots.weak_modes_j}});
}

}  // namespace

void Instrument::take_reference(ReferenceTake take, std::function<void(Result<int>)> done) {
  mailbox_.post([this, take, done = std::move(done)] {
    if (reference_job_) {
      return done(fail(Errc::refused, "",
                       fmt::format("job {} is already taking a reference", *reference_job_)));
    }
    if (auto free = check_free(); !free) return done(fail(free.error()));
    if (state_.pattern != HologramKind::sensor) {
      return done(fail(Errc::refused, "",
                       "the SLM does not show the sensor: call slm.show with \"sensor\" first"));
    }
    if (auto clean = check_introduced(take, state_.aberration); !clean) {
      return done(fail(clean.error()));
    }
    const int job = deps_.jobs.begin(
        "reference.take",
        [this] {
          mailbox_.post([this] {
            if (reference_job_ && !deps_.jobs.runs(*reference_job_)) end_reference_job();
          });
        },
        [this] { return deps_.collector.progress(); });
    reference_job_ = job;
    deps_.on_job(true);
    deps_.pictures.begin(state_.sensor_epoch, shown_hologram_id_);
    deps_.collector.begin(take.frames, state_.sensor_epoch, shown_hologram_id_,
                          snapshot_.get().subapertures,
                          [this, job](ReferenceCollector::Average average) {
                            mailbox_.post([this, job, average] { finish_reference(job, average); });
                          });
    done(job);
  });
}

void Instrument::clear_reference(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    std::vector<Reference> cleared;
    std::vector<std::string> names;
    for (const Reference& one : references_) {
      if (!is_for(one, state_)) continue;
      cleared.push_back(one);
      names.push_back(identity_of(*one.origin));
    }
    auto changed = change_reference(std::nullopt);
    if (!changed) return done(std::move(changed));
    const auto put_back = [this, cleared] {  // they would come back with the next start
      references_.insert(references_.begin(), cleared.begin(), cleared.end());
      (void)change_to(state_);
    };
    archive_.drop(names, when_dropped(std::move(*changed), put_back, done));
  });
}

void Instrument::use_model_reference(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    Reference model = new_reference(ReferenceSource::model);
    model.positions_px = model_positions(state_);
    model.standard_error_px.assign(model.positions_px.size(), Vec2{});
    keep_reference(std::move(model), done);
  });
}

std::vector<Vec2> Instrument::model_positions(const State& state) const {
  return model_spots_px(state.renderer->lattice(), state.sensor, slm_geometry_, optics_of(state),
                        state.roi.width, state.roi.height);
}

/// While the camera is not known, those of any are. Where the model has its spots, no LUT matters.
bool Instrument::is_for(const Reference& reference, const State& state) const {
  return reference.key == reference_key(state.sensor, state.tracking, state.roi) &&
         !of_other_camera(reference, camera_info_) &&
         (reference.source == ReferenceSource::model ||
          (*reference.origin)["slm"] == state.slm->identity);
}

/// Positions that a camera measured which stood otherwise would send every tracker astray: whether
/// both maps expect the spots at the same places.
bool Instrument::is_at_its_place(const Reference& reference, const State& state) const {
  if (reference.source == ReferenceSource::model) return true;
  if (!reference.registration && !state.registration) return true;
  State then = state;
  then.registration = reference.registration;
  // Its base is that of its own sensor, which is the state's.
  if (then.registration) {
    then.registration->base_cpp = base_grating_cpp(state.sensor, slm_geometry_);
  }
  const std::vector<Vec2> before = model_positions(then), now = model_positions(state);
  double farthest_px = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    farthest_px = std::max(farthest_px, norm(now[i] - before[i]));
  }
  return farthest_px <= kSamePlace * lambda_d_px(optics_of(state), slm_geometry_, state.sensor);
}

/// The one taken last, if several cameras' are known and which is in use is not.
const Reference* Instrument::find_reference(const State& state) const {
  const auto found =
      std::find_if(references_.rbegin(), references_.rend(), [&](const Reference& known) {
        return is_for(known, state) && is_at_its_place(known, state);
      });
  return found == references_.rend() ? nullptr : &*found;
}

std::optional<Reference> Instrument::reference_for(const State& state) const {
  const Reference* const found = find_reference(state);
  if (found == nullptr) return std::nullopt;
  Reference reference = *found;
  // A registration says anew where the model's spots are.
  if (reference.source == ReferenceSource::model) reference.positions_px = model_positions(state);
  return reference;
}

/// Whether the same reference and the same calibration are to be used with it.
bool Instrument::know_camera(const std::optional<CameraInfo>& info) {
  const Reference* const before = find_reference(state_);
  const auto calibration = calibrations_.find(calibration_key(state_));
  camera_info_ = info;
  const Reference* const now = find_reference(state_);
  if (before != nullptr && now == nullptr) {
    deps_.events.emit("reference", Severity::warning,
                      title_of(*before) + " is not used: it was taken with another camera",
                      {{"t_taken_ns", before->t_taken_ns}, {"used", false}});
  }
  return before == now && calibration == calibrations_.find(calibration_key(state_));
}

/// An event when another set of settings is not that of the reference; not for every value.
void Instrument::tell_stale() {
  const std::optional<Reference> reference = snapshot_.get().reference;
  std::vector<std::string> fields, words;
  if (reference) {
    for (const StaleField& one : stale_fields(*reference, camera_)) {
      fields.push_back(one.field);
      words.push_back(
          fmt::format("{} was {}, and is {}", one.field, one.then.dump(), one.now.dump()));
    }
  }
  if (fields == stale_told_) return;
  stale_told_ = fields;
  if (!reference) return;
  const std::string how = words.empty() ? "the camera is set as it was then"
                                        : fmt::format("{}", fmt::join(words, "; "));
  deps_.events.emit("reference", fields.empty() ? Severity::info : Severity::warning,
                    title_of(*reference) + " is in force: " + how,
                    {{"t_taken_ns", reference->t_taken_ns}, {"stale", fields}});
}

/// Of now, without its positions.
Reference Instrument::new_reference(ReferenceSource source) const {
  const bool measured = source == ReferenceSource::measured;
  Reference reference;
  reference.key = reference_key(state_.sensor, state_.tracking, state_.roi);
  reference.source = source;
  reference.t_taken_ns = utc_ns();
  reference.registration = registration_of(state_);
  if (measured) reference.aberration = shown_modes(state_);
  if (measured && rms_waves(state_.aberration) > 0.0) reference.introduced = state_.aberration;
  reference.origin = std::make_shared<const nlohmann::json>(archive_.bench().origin(
      {reference.key, reference.aberration, camera_, camera_info_, reference.registration,
       measured ? grey_.get() : nullptr, reference.introduced}));
  return reference;
}

void Instrument::finish_reference(int job, const ReferenceCollector::Average& average) {
  if (reference_job_ != job || !deps_.jobs.runs(job)) return;
  const double most_motion_px =
      kMostMotion * lambda_d_px(optics_of(state_), slm_geometry_, state_.sensor);
  if (auto still = check_average(average, most_motion_px); !still) {
    return fail_reference(still.error());
  }
  const ModeOperator* const own = operator_for(state_);
  const auto spots = judge_spots(
      average, own != nullptr
                   ? *own
                   : slope_operator(state_.renderer->lattice(), state_.sensor, state_.tracking,
                                    px_per_cycle(optics_of(state_), slm_geometry_)));
  if (!spots) return fail_reference(spots.error());
  Reference reference = new_reference(ReferenceSource::measured);
  reference.frames = average.frames;
  reference.positions_px = average.mean_px;
  reference.standard_error_px = average.standard_error_px;
  reference.picture = deps_.pictures.end();
  place_lost(spots->lost, model_positions(state_), reference);
  end_reference_job();
  const double introduced = rms_waves(reference.introduced);
  keep_reference(std::move(reference), [this, job, average, spots = *spots,
                                        introduced](const Result<SensorSnapshot>& changed) {
    if (!changed) return deps_.jobs.fail_job(job, changed.error());
    end_reference(job, average, spots, introduced);
  });
}

/// The reference is active, and its disk has answered.
void Instrument::end_reference(int job, const ReferenceCollector::Average& average,
                               const ReferenceSpots& spots, double introduced_rms_waves) {
  const std::vector<int> saturated = saturated_spots(average);
  if (!saturated.empty()) {
    deps_.events.emit("reference", Severity::warning,
                      fmt::format("spots {} are saturated in frames of the reference: a lower "
                                  "exposure or gain makes a better one",
                                  listed_spots(saturated)),
                      {{"saturated_spots", saturated}});
  }
  warn_of_lost(spots, deps_.events);
  if (introduced_rms_waves > 0.0) warn_of_introduced(introduced_rms_waves);
  deps_.jobs.finish(job, {{"frames", average.frames},
                          {"saturated_spots", saturated},
                          {"lost_spots", spots.lost},
                          {"weak_spots", spots.weak},
                          {"weak_modes", spots.weak_modes_j},
                          {"introduced_rms_waves", introduced_rms_waves},
                          {"drift_px", average.drift_px},
                          {"scatter_px", average.scatter_px},
                          {"noise_px", average.noise_px}});
}

/// A reference that was taken under an aberration is right, and seldom what was wanted.
void Instrument::warn_of_introduced(double rms_waves) {
  deps_.events.emit("reference", Severity::warning,
                    fmt::format("the reference holds the introduced aberration of {:.4f} wave RMS: "
                                "coefficients count from it, and the loop keeps it; for one "
                                "without: aberration.clear, and take it again",
                                rms_waves),
                    {{"introduced_rms_waves", rms_waves}});
}

/// Puts a reference to use, and then on the disk: what cannot be kept is used all the same.
void Instrument::keep_reference(Reference reference, Changed done) {
  const std::string name = identity_of(*reference.origin);
  std::vector<std::string> replaced;  // one of the same identity is overwritten
  for (const Reference& one : references_) {
    const std::string other = identity_of(*one.origin);
    if (is_for(one, state_) && other != name) replaced.push_back(other);
  }
  auto changed = change_reference(std::move(reference));
  if (!changed) return done(std::move(changed));
  const Reference kept = references_.back();
  archive_.keep(
      kept, replaced,
      when_tried([this, kept](const std::string& sha256) { know_reference_file(kept, sha256); },
                 std::move(done)));
}

void Instrument::know_reference_file(const Reference& kept, const std::string& sha256) {
  const auto is_it = [&kept](const Reference& one) {
    return one.t_taken_ns == kept.t_taken_ns && *one.origin == *kept.origin;
  };
  for (Reference& one : references_) {
    if (is_it(one)) one.sha256 = sha256;
  }
  snapshot_.change([&](SensorSnapshot& now) {
    if (now.reference && is_it(*now.reference)) now.reference->sha256 = sha256;
  });
}

void Instrument::limit_pictures() {
  for (std::size_t i = 0; i + kMostPictures < references_.size(); ++i) {
    references_[i].picture.reset();
  }
}

/// Puts a reference in force for the present state, or none; on an error the one before stays.
Result<SensorSnapshot> Instrument::change_reference(std::optional<Reference> reference) {
  std::vector<Reference> before = references_;
  std::erase_if(references_, [&](const Reference& known) { return is_for(known, state_); });
  if (reference) references_.push_back(std::move(*reference));
  limit_pictures();
  auto changed = change_to(state_);
  if (!changed) references_ = std::move(before);
  return changed;
}

void Instrument::fail_reference(const Error& why) {
  const int job = *reference_job_;
  reference_job_.reset();
  deps_.on_job(false);  // who hears of the end may ask for the next
  deps_.jobs.fail_job(job, why);
  deps_.collector.cancel();  // it told the job's progress until now
  deps_.pictures.cancel();
}

void Instrument::end_reference_job() {
  if (!reference_job_) return;
  deps_.collector.cancel();
  deps_.pictures.cancel();
  reference_job_.reset();
  deps_.on_job(false);
}

/// A reference that gets no settled frames must end: its caller waits, and the sensor is locked
/// meanwhile.
void Instrument::watch_reference_job() {
  if (!reference_job_) return;
  deps_.jobs.tell_progress(*reference_job_);
  const double period_s =
      camera_ ? std::max(1.0 / camera_->frame_rate_hz, 1e-6 * camera_->exposure_us) : 0.0;
  const double patience_s = std::max(10.0, 3.0 * period_s);
  if (deps_.collector.idle_s() < patience_s) return;
  fail_reference(Error{Errc::unavailable, "",
                       fmt::format("no settled frame came for {:.0f} s: see system.status for what "
                                   "the camera and the SLM do",
                                   patience_s)});
}

}  // namespace ovws
