/// Which operator the plans read modes with: what is asked for, as soon as it is made.
#include <spdlog/fmt/fmt.h>

#include "daemon/ovwsd/sensor/instrument.hpp"
#include "proto/names.hpp"

namespace ovws {

/// Null: the slopes.
const ModeOperator* Instrument::operator_for(const State& state) const {
  if (state.tracking.mode_operator == OperatorKind::slopes) return nullptr;
  if (state.tracking.mode_operator == OperatorKind::measured) {
    const auto measured = calibrations_.find(calibration_key(state));
    return measured ? &measured->mode_operator : nullptr;
  }
  const auto* const made =
      operators_.find(operator_key(state.sensor, state.tracking, optics_of(state), state.roi));
  return made != nullptr && *made ? &**made : nullptr;
}

/// Of the present state, whose plan is adopted. Orders what is asked for and was never made.
OperatorReport Instrument::report_operator(const MeasurementPlan& plan) {
  const OperatorKey key =
      operator_key(state_.sensor, state_.tracking, optics_of(state_), state_.roi);
  const bool diffractive = state_.tracking.mode_operator == OperatorKind::diffractive;
  operators_.forget_shortages(diffractive ? &key : nullptr);
  if (plan.mode_operator == state_.tracking.mode_operator) {
    deps_.operators.give_up();
    return {plan.mode_operator, ""};
  }
  if (state_.tracking.mode_operator == OperatorKind::measured) {
    deps_.operators.give_up();
    return {plan.mode_operator, calibrations_.why_none(calibration_key(state_))};
  }
  if (const auto* const made = operators_.find(key)) {
    return {plan.mode_operator, made->error().reason};
  }
  deps_.operators.order(key, [this](const OperatorKey& of, Result<ModeOperator> made) {
    mailbox_.post([this, of, made = std::move(made)]() mutable { keep(of, std::move(made)); });
  });
  return {plan.mode_operator, "its matrix is being made: that takes some seconds"};
}

/// Positions do not depend on the operator: a reference that is being taken goes on.
void Instrument::keep(const OperatorKey& key, Result<ModeOperator> made) {
  if (!made) {
    deps_.events.emit("sensor", Severity::warning,
                      "there is no diffractive operator: " + made.error().reason,
                      {{"operator", "diffractive"}});
  }
  operators_.put(key, std::move(made));
  const bool wanted =
      state_.tracking.mode_operator == OperatorKind::diffractive &&
      key == operator_key(state_.sensor, state_.tracking, optics_of(state_), state_.roi);
  if (!wanted) return;
  auto plan = plan_for(state_, shown_hologram_id_);
  if (plan) adopt(state_, std::move(*plan));
}

void Instrument::tell_operator(OperatorKind before, OperatorKind now) {
  if (now == before) return;
  deps_.events.emit("sensor", Severity::info,
                    fmt::format("modes are read by the operator {}", operator_name(now)),
                    {{"operator", operator_name(now)}});
}

}  // namespace ovws
