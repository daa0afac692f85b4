#include "daemon/ovwsd/sensor/sensor_events.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "proto/json_text.hpp"
#include "proto/names.hpp"

namespace ovws {

void SensorEvents::publish_changes(const SensorSnapshot& before, const SensorSnapshot& now) {
  const OperatorKind in_use = now.mode_operator.in_force;
  if (in_use == before.mode_operator.in_force) return;
  events_.emit("sensor", Severity::info,
               fmt::format("modes are reconstructed with the operator {}", wire_name(in_use)),
               {{"operator", wire_name(in_use)}});
}

void SensorEvents::publish_unused(const Reference& reference, const SensorState& state,
                                  const Knowledge& knowledge) {
  const std::string why = unused_reason(reference, state, knowledge, bench_, false);
  if (why.empty()) return;
  events_.emit("reference", Severity::warning,
               fmt::format("{} is not used: {}; {}",
                           title_of(kReferenceItems, reference.t_taken_ns), why, kUnusedRemedy),
               {{"t_taken_ns", reference.t_taken_ns}, {"used", false}});
}

void SensorEvents::publish_stale(const Reference* reference,
                                 const std::optional<CameraSettings>& camera) {
  std::vector<std::string> fields, words;
  if (reference != nullptr) {
    for (const StaleField& one : stale_fields(*reference, camera)) {
      fields.push_back(one.field);
      words.push_back(
          fmt::format("{} was {}, and is {}", one.field, json_text(one.then), json_text(one.now)));
    }
  }
  if (fields == published_stale_) return;
  published_stale_ = fields;
  if (reference == nullptr) return;
  const std::string how = words.empty() ? "the camera's settings are those that it was taken with"
                                        : fmt::format("{}", fmt::join(words, "; "));
  events_.emit("reference", fields.empty() ? Severity::info : Severity::warning,
               title_of(kReferenceItems, reference->t_taken_ns) +
                   (fields.empty() ? " is active: " : " is active, but stale: ") + how,
               {{"t_taken_ns", reference->t_taken_ns}, {"stale", fields}});
}

const std::string& SensorEvents::layout_fault(const SensorState& state) {
  const OpticsConfig optics = optics_of(state, bench_);
  LayoutKey key{state.sensor,     state.tracking, optics.registered,
                optics.centre_px, state.roi,      state.format};
  if (!layouts_.empty() && layouts_.back().key == key) return layouts_.back().fault;
  const bool first = layouts_.empty();
  const auto found = std::find_if(layouts_.begin(), layouts_.end(),
                                  [&](const Layout& one) { return one.key == key; });
  if (found != layouts_.end()) {
    std::rotate(found, found + 1, layouts_.end());
  } else {
    const auto seen = check_layout(state, bench_);
    layouts_.push_back(
        {std::move(key), seen ? "" : text_of(seen.error()), seen ? "" : seen.error().field});
    if (layouts_.size() > kMaxLayouts) layouts_.pop_front();
  }
  const Layout& now = layouts_.back();
  if (!now.fault.empty()) {
    events_.emit("sensor", first ? Severity::error : Severity::warning, now.fault,
                 {{"field", now.field}});
  }
  return now.fault;
}

}  // namespace ovws
