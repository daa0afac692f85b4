/// Events that report changes of the sensor to subscribers.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/port/camera.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Publishes events about operator, reference and spot layout. Not thread-safe.
class SensorEvents {
 public:
  SensorEvents(BenchOptics bench, Events& events) : bench_(std::move(bench)), events_(events) {}

  /// Publishes a change of the active operator.
  void publish_changes(const SensorSnapshot& before, const SensorSnapshot& now);
  /// Publishes why a previously active reference is not used in this state, if there is a reason.
  void publish_unused(const Reference& reference, const SensorState& state,
                      const Knowledge& knowledge);
  /// Publishes which camera settings differ from the reference's (null: no reference), whenever the
  /// set of differing settings changes. Another value of a differing setting is not published.
  void publish_stale(const Reference* reference, const std::optional<CameraSettings>& camera);
  /// Why the camera cannot see the spots, or the tracker cannot separate them; empty: no known
  /// problem. Publishes the fault when an input has changed. Keeps the results of the last inputs:
  /// with a mask or `mode_count` the check renders the spots, which takes up to a second.
  const std::string& layout_fault(const SensorState& state);

 private:
  using LayoutKey = std::tuple<SensorConfig, TrackingSettings, std::optional<PxPerCycle>,
                               std::optional<Vec2>, Roi, PixelFormat>;

  BenchOptics bench_;
  Events& events_;
  std::vector<std::string> published_stale_;  ///< settings named in the last event
  struct Layout {
    LayoutKey key;  ///< the inputs
    std::string fault, field;
  };
  static constexpr std::size_t kMaxLayouts = 9;  ///< eight prepared lattices, and another
  std::deque<Layout> layouts_;                   ///< the last is that of the present sensor
};

}  // namespace ovws
