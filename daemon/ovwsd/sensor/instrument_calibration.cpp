/// Calibrations: which belongs to the present state, and how one comes in force.
#include <spdlog/fmt/fmt.h>

#include "daemon/ovwsd/sensor/instrument.hpp"

namespace ovws {
namespace {

/// A calibration that lacks spots or modes is usable, and a person must know.
void warn_of_dropped(const InteractionMatrix& matrix, Events& events) {
  std::vector<int> dropped_j;
  for (const DroppedMode& mode : matrix.dropped) dropped_j.push_back(mode.j);
  if (dropped_j.empty() && matrix.lost_spots.empty()) return;
  std::string text = "the calibration";
  if (!matrix.lost_spots.empty()) {
    text += fmt::format(" lacks spots {}", listed_spots(matrix.lost_spots));
  }
  if (!dropped_j.empty()) {
    text += fmt::format("{} reads no modes j = {} ({}): what they hold is read as other modes",
                        matrix.lost_spots.empty() ? "" : " and", listed_spots(dropped_j),
                        matrix.dropped[0].reason);
  }
  events.emit("calibration", Severity::warning, text,
              {{"lost_spots", matrix.lost_spots}, {"dropped_modes", dropped_j}});
}

}  // namespace

CalibrationKey Instrument::calibration_key(const State& state) const {
  CalibrationKey key =
      ovws::calibration_key(reference_key(state.sensor, state.tracking, state.roi), optics_,
                            slm_geometry_, registration_of(state), camera_json(camera_info_));
  key.slm = state.slm->identity;
  return key;
}

/// What is asked for must be there, but what was in force may go with what it belonged to.
Result<void> Instrument::check_operator(const SensorSet& change, const State& next) const {
  const bool asked = change.gives(&TrackingSettings::mode_operator) &&
                     next.tracking.mode_operator == OperatorKind::measured;
  if (!asked) return {};
  const CalibrationKey key = calibration_key(next);
  if (calibrations_.find(key)) return {};
  return fail(Errc::refused, "operator", calibrations_.why_none(key));
}

void Instrument::use_calibration(int job, std::uint64_t sensor_epoch, MeasuredCalibration measured,
                                 Changed done) {
  mailbox_.post(
      [this, job, sensor_epoch, measured = std::move(measured), done = std::move(done)]() mutable {
        adopt_calibration(job, sensor_epoch, std::move(measured), std::move(done));
      });
}

void Instrument::adopt_calibration(int job, std::uint64_t sensor_epoch,
                                   MeasuredCalibration measured, Changed done) {
  auto next = lent_state(job);
  if (!next) return done(fail(next.error()));
  if (!deps_.jobs.runs(job)) return done(fail(Errc::refused, "", "it was cancelled"));
  if (state_.sensor_epoch != sensor_epoch) {
    return done(fail(Errc::refused, "camera", "the camera or its region changed meanwhile"));
  }
  Calibration calibration{std::move(measured), calibration_key(state_), {}, nullptr, ""};
  calibration.mode_operator = mode_operator_of(calibration.matrix);
  calibration.origin = std::make_shared<const nlohmann::json>(
      archive_.bench().origin({calibration.key.sensor, shown_modes(state_), camera_, camera_info_,
                               registration_of(state_), grey_.get()}));
  warn_of_dropped(calibration.matrix, deps_.events);
  const std::int64_t t_taken_ns = calibration.t_taken_ns;
  const auto know = [this, t_taken_ns](const std::string& sha256) {
    const auto known = calibrations_.know_file(t_taken_ns, sha256);
    if (!known) return;
    snapshot_.change([&](SensorSnapshot& now) {
      if (now.calibration && now.calibration->t_taken_ns == t_taken_ns) now.calibration = known;
    });
  };
  const auto tried = std::make_shared<Result<SensorSnapshot>>(snapshot_.get());
  calibrations_.put(std::move(calibration),
                    when_tried(know, [tried, done](const Result<SensorSnapshot>& now) {
                      done(*tried ? now : fail(tried->error()));
                    }));
  next->tracking.mode_operator = OperatorKind::measured;
  *tried = carry_out(std::move(*next));
  if (*tried)
    lease_->tracking.mode_operator = OperatorKind::measured;  // when the job has ended too
}

void Instrument::clear_calibration(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    const auto taken = calibrations_.take(calibration_key(state_));
    auto changed = carry_out(state_);
    if (!changed) {
      calibrations_.put_back(taken);
      return done(std::move(changed));
    }
    const auto put_back = [this, taken] {
      calibrations_.put_back(taken);
      (void)carry_out(state_);
    };
    calibrations_.drop_files(taken, when_dropped(std::move(*changed), put_back, done));
  });
}

}  // namespace ovws
