/// A change of the sensor on its way: it comes into force as a whole, or not at all.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/knowledge.hpp"
#include "daemon/ovwsd/sensor/sensor_bench.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// What is shown again when the job ends that has the sensor.
struct Lease {
  SensorConfig sensor;
  TrackingSettings tracking;
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;
};

struct SensorEdit {
  SensorState state;
  Knowledge knowledge;
  std::optional<Lease> lease;  ///< of the job that has the sensor
  SensorBench& bench;
  bool files_only = false;  ///< state and knowledge are as before

  /// Once it is in force: writes a file, and tells its checksum, empty if it cannot be kept; then
  /// again, if it is kept after all.
  std::function<void(std::function<void(const std::string& sha256)>)> keep{};
  /// With that checksum; changes no more than what is said of the file.
  std::function<void(SensorEdit&, const std::string& sha256)> set_checksum{};
  /// Once it is in force: removes files.
  std::function<void(DaemonStore::Dropped)> drop{};
  /// If they cannot be removed: a change that puts things back as they were.
  std::function<Result<void>(SensorEdit&)> undo{};
};

/// Errors: why it cannot be; then nothing changes.
using SensorChange = std::function<Result<void>(SensorEdit&)>;

}  // namespace ovws
