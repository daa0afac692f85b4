/// What was measured of the SLM itself: the look-up table, the flatness.
#include <algorithm>
#include <iterator>

#include "daemon/ovwsd/sensor/instrument.hpp"

namespace ovws {

/// Every picture is another one from now on, and what was measured of those before belongs to them.
Result<SensorSnapshot> Instrument::change_slm(std::shared_ptr<const SlmInForce> slm) {
  State next = state_;
  next.slm = std::move(slm);
  ++next.sensor_epoch;
  const std::optional<Reference> before = reference_for(state_);
  archive_.use_slm(*next.slm);
  load_for_slm();
  auto changed = carry_out(std::move(next));
  if (!changed) archive_.use_slm(*state_.slm);
  if (changed && before && !changed->reference) {
    deps_.events.emit("reference", Severity::warning,
                      title_of(*before) +
                          " is not used: the SLM is driven otherwise than when it was taken; take "
                          "another one",
                      {{"t_taken_ns", before->t_taken_ns}, {"used", false}});
  }
  return changed;
}

/// What belongs to the SLM of now and was not used at the start.
void Instrument::load_for_slm() {
  auto more = archive_.load_again();
  std::move(more.begin(), more.end(), std::back_inserter(references_));
  std::stable_sort(
      references_.begin(), references_.end(),
      [](const Reference& a, const Reference& b) { return a.t_taken_ns < b.t_taken_ns; });
  limit_pictures();
  calibrations_.load_again();
}

/// The same as is active, with the checksum of its file.
template <class T>
std::function<void(const std::string&)> Instrument::know_file_of(
    const T& measured, std::shared_ptr<const T> SlmInForce::*part) {
  return [this, t_taken_ns = measured.t_taken_ns, part](const std::string& sha256) {
    const std::shared_ptr<const T> now = (*state_.slm).*part;
    if (!now || now->t_taken_ns != t_taken_ns) return;
    auto with_file = std::make_shared<T>(*now);
    with_file->sha256 = sha256;
    auto slm = std::make_shared<SlmInForce>(*state_.slm);
    (*slm).*part = std::move(with_file);
    state_.slm = std::move(slm);
    snapshot_.change([this](SensorSnapshot& known) { known.slm = state_.slm; });
  };
}

nlohmann::json Instrument::origin_of_slm() const {
  const ReferenceKey key = reference_key(state_.sensor, state_.tracking, state_.roi);
  return archive_.bench().origin(
      {key, shown_modes(state_), camera_, camera_info_, registration_of(state_), nullptr});
}

void Instrument::use_lut(int job, MeasuredLut lut, Changed done) {
  mailbox_.post([this, job, lut = std::move(lut), done = std::move(done)]() mutable {
    if (auto lent = lent_state(job); !lent) return done(fail(lent.error()));
    if (!deps_.jobs.runs(job)) return done(fail(Errc::refused, "", "it was cancelled"));
    lut.origin = origin_of_slm();
    auto changed =
        change_slm(slm_in_force(archive_.bench().config(), hologram_,
                                std::make_shared<const MeasuredLut>(lut), state_.slm->flatness));
    if (!changed) return done(std::move(changed));
    slm_archive_.keep(lut, when_tried(know_file_of(lut, &SlmInForce::lut), std::move(done)));
  });
}

void Instrument::use_flatness(int job, std::uint64_t sensor_epoch, MeasuredFlatness flatness,
                              Changed done) {
  mailbox_.post([this, job, sensor_epoch, flatness = std::move(flatness),
                 done = std::move(done)]() mutable {
    if (auto lent = lent_state(job); !lent) return done(fail(lent.error()));
    if (!deps_.jobs.runs(job)) return done(fail(Errc::refused, "", "it was cancelled"));
    if (state_.sensor_epoch != sensor_epoch) {
      return done(fail(Errc::refused, "camera", "the camera or its region changed meanwhile"));
    }
    flatness.origin = origin_of_slm();
    flatness.configured_sha256 = flatness_sha256(hologram_);
    auto changed = change_slm(slm_in_force(archive_.bench().config(), hologram_, state_.slm->lut,
                                           std::make_shared<const MeasuredFlatness>(flatness)));
    if (!changed) return done(std::move(changed));
    slm_archive_.keep(flatness,
                      when_tried(know_file_of(flatness, &SlmInForce::flatness), std::move(done)));
  });
}

/// Not used any more first, and then off the disk: what fails is undone without a display, too.
void Instrument::clear_slm(const std::shared_ptr<const SlmInForce>& cleared,
                           void (SlmArchive::*drop)(DaemonStore::Dropped), Changed done) {
  const std::shared_ptr<const SlmInForce> before = state_.slm;
  const bool measured = cleared->lut != before->lut || cleared->flatness != before->flatness;
  auto changed = measured ? change_slm(cleared) : snapshot_.get();
  if (!changed) return done(std::move(changed));
  const auto put_back = [this, measured, cleared, before] {
    if (measured && state_.slm == cleared) force_slm(before);
  };
  (slm_archive_.*drop)(when_dropped(std::move(*changed), put_back, std::move(done)));
}

/// Shown as soon as there is a display.
void Instrument::force_slm(std::shared_ptr<const SlmInForce> slm) {
  State next = state_;
  next.slm = std::move(slm);
  if (!renew_renderer(next)) return;
  archive_.use_slm(*next.slm);
  fall_back_to(std::move(next));
}

/// Another camera stands behind other optics.
void Instrument::check_flatness() {
  const auto& flatness = state_.slm->flatness;
  if (!flatness || !camera_info_) return;
  const nlohmann::json then = flatness->origin.value("camera", nlohmann::json());
  if (then.is_null() || then == camera_json(camera_info_)) return;
  deps_.events.emit("slm", Severity::warning,
                    "the flatness is not used, and left on the disk: it was measured with another "
                    "camera",
                    {{"t_taken_ns", flatness->t_taken_ns}, {"used", false}});
  auto without = slm_in_force(archive_.bench().config(), hologram_, state_.slm->lut, nullptr);
  if (!change_slm(without)) force_slm(std::move(without));
}

void Instrument::clear_lut(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    clear_slm(slm_in_force(archive_.bench().config(), hologram_, nullptr, state_.slm->flatness),
              &SlmArchive::drop_lut, done);
  });
}

void Instrument::clear_flatness(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    clear_slm(slm_in_force(archive_.bench().config(), hologram_, state_.slm->lut, nullptr),
              &SlmArchive::drop_flatness, done);
  });
}

}  // namespace ovws
