/// What others may know of the sensor at any time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

/// Immutable; shared by all who look.
struct SensorSnapshot {
  SensorConfig sensor;
  TrackingSettings tracking;
  TemplateReport templates;      ///< what of tracking.templates is in use
  OperatorReport mode_operator;  ///< of plan_id
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;  ///< shown on purpose, RMS-normalised waves
  std::vector<Mode> correction;  ///< subtracted from the hologram
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< of the plan
  OpticsConfig optics;             ///< in the camera's region: as configured, or as registered
  std::optional<Registration> registration;  ///< the active one, in pixels of the camera's sensor
  std::uint64_t plan_id = 0;  ///< frames measured with this plan are of all that stands here
  int subapertures = 0;
  std::vector<int> modes_j;
  std::string layout_fault;  ///< why the camera cannot see the spots, or the tracker tell them
                             ///< apart; empty: nothing is known to be wrong
  std::vector<int> torn;  ///< spots that are followed by the shapes that the wavefront gives them
  std::shared_ptr<const Reference> reference;      ///< the active one; null: none
  std::shared_ptr<const Calibration> calibration;  ///< that belongs to all this; null: none
  std::shared_ptr<const SlmInForce> slm;           ///< LUT and flatness; never null
};
using SensorView = std::shared_ptr<const SensorSnapshot>;

}  // namespace ovws
