/// Events about changes of the sensor.
#pragma once

#include <optional>
#include <string>
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

  /// The spots that are followed as split ones, and the operator, if they are others than before.
  void publish_changes(const SensorSnapshot& before, const SensorSnapshot& now);
  /// The reference was in use before, is still known, and does not belong to this state any more.
  void publish_unused(const Reference& reference, const SensorState& state,
                      const Knowledge& knowledge);
  /// When another set of settings is not that of the reference (null: none); not for every value.
  void publish_stale(const Reference* reference, const std::optional<CameraSettings>& camera);
  /// Why the camera cannot see the spots, or the tracker tell them apart; empty: nothing is known
  /// to be wrong. Judged, and told, once for all that decides it.
  const std::string& layout_fault(const SensorState& state);

 private:
  struct LayoutKey {
    SensorConfig sensor;
    TrackerKind tracker = TrackerKind::lg;
    std::optional<PxPerCycle> registered;
    std::optional<Vec2> centre_px;
    Roi roi;
    friend bool operator==(const LayoutKey&, const LayoutKey&) = default;
  };

  BenchOptics bench_;
  Events& events_;
  std::vector<std::string> stale_told_;  ///< fields, by the last event
  std::optional<LayoutKey> layout_key_;  ///< of layout_fault_
  std::string layout_fault_;
};

}  // namespace ovws
