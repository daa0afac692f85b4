#include "daemon/ovwsd/sensor/reference.hpp"

#include <cmath>

namespace ovws {

ReferenceKey reference_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                           const Roi& roi) {
  ReferenceKey key{sensor, tracking, roi};
  if (tracking.tracker == TrackerKind::fit) key.tracking.tracker = TrackerKind::lg;
  key.tracking.mode_operator = OperatorKind::slopes;
  key.tracking.mode_count.reset();
  key.tracking.estimates = TrackingSettings{}.estimates;
  return key;
}

ReferenceKey calibrated_sensor(const SensorConfig& sensor, const TrackingSettings& tracking,
                               const Roi& roi) {
  ReferenceKey key = reference_key(sensor, tracking, roi);
  if (tracking.tracker != TrackerKind::fit) return key;
  key.tracking.tracker = TrackerKind::fit;
  key.tracking.mode_count = tracking.mode_count;
  return key;
}

double rms_waves(const std::vector<Mode>& modes) {
  double square = 0.0;
  for (const Mode& mode : modes) square += mode.waves * mode.waves;
  return std::sqrt(square);
}

}  // namespace ovws
