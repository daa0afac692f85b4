/// Events about changes of the sensor.
#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/port/camera.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// One thread at a time.
class SensorEvents {
 public:
  SensorEvents(BenchOptics bench, Events& events) : bench_(std::move(bench)), events_(events) {}

  /// Publishes a change of the active operator.
  void publish_changes(const SensorSnapshot& before, const SensorSnapshot& now);
  /// Publishes why a reference that was active is not used in this state.
  void publish_unused(const Reference& reference, const SensorState& state,
                      const Knowledge& knowledge);
  /// Publishes when the set of camera settings that differ from the reference's has changed (null:
  /// no reference). Further changes of the same settings are not published.
  void publish_stale(const Reference* reference, const std::optional<CameraSettings>& camera);
  /// Why the camera cannot see the spots, or the tracker cannot separate them; empty: no known
  /// problem. Checks again, and publishes a fault, only when an input of the check has changed.
  const std::string& layout_fault(const SensorState& state);

 private:
  using LayoutKey = std::tuple<SensorConfig, TrackingSettings, std::optional<PxPerCycle>,
                               std::optional<Vec2>, Roi>;

  BenchOptics bench_;
  Events& events_;
  std::vector<std::string> published_stale_;  ///< fields in the last event
  std::optional<LayoutKey> layout_key_;       ///< inputs of layout_fault_
  std::string layout_fault_;
};

}  // namespace ovws
