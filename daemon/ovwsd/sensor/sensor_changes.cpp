#include "daemon/ovwsd/sensor/sensor_changes.hpp"

#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

/// Refuses a request for the operator `measured` if no calibration applies. If `measured` is
/// already set and another change makes the calibration inapplicable, the slope operator is used
/// instead.
Result<void> check_operator(const SensorSet& change, const SensorEdit& edit) {
  const bool asked = change.gives(&TrackingSettings::mode_operator) &&
                     edit.state.tracking.mode_operator == OperatorKind::measured;
  if (!asked || calibration_for(edit.state, edit.knowledge, edit.bench.optics)) return {};
  return fail(Errc::refused, "operator",
              missing_calibration_reason(edit.state, edit.knowledge, edit.bench.optics) +
                  ": run calibration.run");
}

/// A mask file in use, or named by the configuration, is not read again: this thread must not wait
/// for a disk.
void apply(const SensorSet& change, const Masks& configured, SensorState& state) {
  SensorSettings changed = change.applied_to({state.sensor, state.tracking});
  adopt_maps(changed.sensor.masks, state.sensor.masks);
  adopt_maps(changed.sensor.masks, configured);
  state.sensor = std::move(changed.sensor);
  state.tracking = changed.tracking;
}

/// Lenslets are hardware: neither can a request change an array, nor make one of an SLM.
Result<void> check_lenslets(const SensorConfig& before, const SensorConfig& now) {
  const bool stays = before.lenslets.empty() ? now.lenslets.empty() : now == before;
  if (stays) return {};
  return fail(Errc::refused, "",
              "lenslets are fixed: change `modulator`, `array` and `sensor` in the configuration "
              "file and restart the daemon; registration.run finds the array in the image");
}

}  // namespace

SensorChange set_sensor(SensorSet change, std::optional<Masks> read_masks) {
  return [set = set_unchecked_sensor(std::move(change), std::move(read_masks))](
             SensorEdit& edit) -> Result<void> {
    if (auto changed = set(edit); !changed) return changed;
    return check_spots(edit.state, edit.bench.optics);
  };
}

SensorChange set_unchecked_sensor(SensorSet change, std::optional<Masks> read_masks) {
  return [change = std::move(change),
          read_masks = std::move(read_masks)](SensorEdit& edit) -> Result<void> {
    const SensorConfig before = edit.state.sensor;
    apply(change, read_masks ? *read_masks : edit.bench.config.sensor.masks, edit.state);
    if (auto fixed = check_lenslets(before, edit.state.sensor); !fixed) return fixed;
    if (auto there = check_operator(change, edit); !there) return there;
    return check_daemon_tracker(edit.state.tracking);
  };
}

SensorChange set_aberration(std::vector<Mode> modes) {
  return [modes = std::move(modes)](SensorEdit& edit) -> Result<void> {
    edit.state.aberration = modes;
    edit.state.sequence.clear();
    return {};
  };
}

SensorChange set_sequence(std::vector<std::vector<Mode>> patterns, PatternCycle cycle) {
  return [patterns = std::move(patterns), cycle](SensorEdit& edit) -> Result<void> {
    edit.state.aberration.clear();
    edit.state.sequence = patterns;
    edit.state.cycle = cycle;
    return {};
  };
}

SensorChange set_correction(std::vector<Mode> modes) {
  return [modes = std::move(modes)](SensorEdit& edit) -> Result<void> {
    edit.state.correction = modes;
    return {};
  };
}

SensorChange show_pattern(HologramKind pattern) {
  return [pattern](SensorEdit& edit) -> Result<void> {
    edit.state.pattern = pattern;
    edit.state.painted.reset();
    return {};
  };
}

SensorChange show_request(ShowRequest what) {
  return [what = std::move(what)](SensorEdit& edit) -> Result<void> {
    SensorState& state = edit.state;
    std::shared_ptr<Image<std::uint8_t>> painted;
    if (what.paint) {
      painted = std::make_shared<Image<std::uint8_t>>();
      what.paint(*state.renderer, *painted);
    }
    apply(what.sensor, edit.bench.config.sensor.masks, state);
    if (auto fast = check_daemon_tracker(state.tracking); !fast) return fast;
    state.aberration = what.aberration;
    state.sequence.clear();
    state.pattern = painted ? HologramKind::test : HologramKind::sensor;
    state.painted = std::move(painted);
    return {};
  };
}

}  // namespace ovws
