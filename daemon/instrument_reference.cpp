#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "core/port/clock.hpp"
#include "daemon/instrument.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMostPictures = 8;  // of the references taken last: some MiB each

std::string listed(const std::vector<int>& numbers) {
  constexpr std::size_t kNamed = 8;
  const std::size_t named = std::min(numbers.size(), kNamed);
  std::string text = fmt::format("{}", fmt::join(numbers.begin(), numbers.begin() + named, ", "));
  if (numbers.size() > named) text += fmt::format(" and {} more", numbers.size() - named);
  return text;
}

}  // namespace

void Instrument::take_reference(int frames, std::function<void(Result<int>)> done) {
  mailbox_.post([this, frames, done = std::move(done)] {
    if (reference_job_) {
      return done(fail(Errc::refused, "",
                       fmt::format("job {} is already taking a reference", *reference_job_)));
    }
    if (state_.pattern != HologramKind::sensor) {
      return done(fail(Errc::refused, "",
                       "the SLM does not show the sensor: call slm.show with \"sensor\" first"));
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
    deps_.collector.begin(frames, state_.sensor_epoch, shown_hologram_id_,
                          snapshot_.get().subapertures,
                          [this, job](ReferenceCollector::Average average) {
                            mailbox_.post([this, job, average] { finish_reference(job, average); });
                          });
    done(job);
  });
}

void Instrument::clear_reference(Changed done) {
  mailbox_.post([this, done = std::move(done)] { done(change_reference(std::nullopt)); });
}

std::optional<Reference> Instrument::reference_for(const State& state) const {
  const ReferenceKey key = reference_key(state.sensor, state.tracking, state.roi);
  for (const Reference& known : references_) {
    if (known.key == key) return known;
  }
  return std::nullopt;
}

void Instrument::finish_reference(int job, const ReferenceCollector::Average& average) {
  if (reference_job_ != job || !deps_.jobs.runs(job)) return;
  std::vector<int> too_rare;
  for (std::size_t i = 0; i < average.found.size(); ++i) {
    if (2 * average.found[i] < average.frames) too_rare.push_back(int(i));
  }
  if (!too_rare.empty()) {
    return fail_reference(Error{
        Errc::refused, "",
        fmt::format("spots {} were found in fewer than half of the frames: check the image, the "
                    "exposure and the region of interest, or use fewer subapertures",
                    listed(too_rare))});
  }
  Reference reference;
  reference.key = reference_key(state_.sensor, state_.tracking, state_.roi);
  reference.frames = average.frames;
  reference.t_taken_ns = utc_ns();
  reference.aberration = state_.aberration;
  reference.positions_px = average.mean_px;
  reference.standard_error_px = average.standard_error_px;
  reference.picture = deps_.pictures.end();
  end_reference_job();
  if (auto changed = change_reference(std::move(reference)); !changed) {
    return deps_.jobs.fail_job(job, changed.error());
  }
  deps_.jobs.finish(job, {{"frames", average.frames}});
}

/// Puts a reference in force for the present state, or none; on an error the one before stays.
Result<SensorSnapshot> Instrument::change_reference(std::optional<Reference> reference) {
  const ReferenceKey key = reference_key(state_.sensor, state_.tracking, state_.roi);
  std::vector<Reference> before = references_;
  std::erase_if(references_, [&](const Reference& known) { return known.key == key; });
  if (reference) references_.push_back(std::move(*reference));
  for (std::size_t i = 0; i + kMostPictures < references_.size(); ++i) {
    references_[i].picture.reset();
  }
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
