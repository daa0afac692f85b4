/// A change of the sensor in progress. It takes effect as a whole, or not at all.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/sensor_bench.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// What to restore when the job that holds the sensor ends.
struct Lease {
  SensorConfig sensor;
  TrackingSettings tracking;
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;
};

/// Copies of the sensor's state that a change modifies, and what to do once it is active.
struct SensorEdit {
  SensorState state;
  Knowledge knowledge;
  std::optional<Lease> lease;  ///< of the job that holds the sensor
  SensorBench& bench;
  bool files_only = false;  ///< state and knowledge are unchanged

  /// Called when the change is active: writes a file and reports its checksum. Reports an empty
  /// checksum if writing fails, and the real one if a retry succeeds later.
  std::function<void(std::function<void(const std::string& sha256)>)> keep{};
  /// Called with that checksum. Changes nothing but the checksum of the item.
  std::function<void(SensorEdit&, const std::string& sha256)> set_checksum{};
  /// Called when the change is active: removes files.
  std::function<void(DaemonStore::Dropped)> drop{};
  /// Called if they cannot be removed: a change that restores the previous state.
  std::function<Result<void>(SensorEdit&)> undo{};
};

/// Modifies the edit. On an error nothing changes.
using SensorChange = std::function<Result<void>(SensorEdit&)>;

}  // namespace ovws
