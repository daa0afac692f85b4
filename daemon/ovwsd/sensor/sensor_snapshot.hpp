/// Snapshot of the sensor's state, for threads other than the prepare thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/pipeline/plan.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/library/calibration.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "daemon/ovwsd/sensor/beams.hpp"
#include "proto/status_message.hpp"
#include "proto/tables/sensor.hpp"

namespace ovws {

/// Settings that a job may change temporarily. They are restored when the job ends.
struct SensorShown {
  SensorConfig sensor;
  TrackingSettings tracking;
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;  ///< introduced, RMS-normalised waves
  /// Introduced by each pattern of a DMD's sequence, in place of `aberration`; empty: no sequence.
  std::vector<std::vector<Mode>> sequence;
  PatternCycle cycle;  ///< of `sequence`
};

/// What spot templates are made for: they are valid until any of it changes.
struct TemplatesKey {
  std::uint64_t sensor_epoch = 0;
  std::int64_t reference_taken_ns = 0;    ///< UTC; 0: no reference
  std::int64_t calibration_taken_ns = 0;  ///< UTC; 0: no calibration gives measured templates
  friend bool operator==(const TemplatesKey&, const TemplatesKey&) = default;
};

/// The sensor's settings and active measurements. Immutable and shared by all readers.
struct SensorSnapshot : SensorShown {
  OperatorReport mode_operator;  ///< the operator of plan `plan_id`
  std::vector<Mode> correction;  ///< subtracted from the hologram
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< the sensor's epoch, as in plan `plan_id`
  TemplatesKey templates_for;      ///< what new templates are made for
  OpticsConfig optics;             ///< pixels of the camera's region; with the registration, if any
  std::optional<Registration> registration;  ///< the active one; pixels of the camera's sensor
  /// The active plan, built from the settings of this snapshot; 0: none could be built from them,
  /// and no frame is valid.
  std::uint64_t plan_id = 0;
  int subapertures = 0;
  std::vector<BeamShown> beams;  ///< the further light sources
  std::optional<Disc> region;    ///< MeasurementPlan::region of the main one
  std::vector<int> modes_j;
  std::vector<int> position_modes_j;  ///< leading part of modes_j that spot positions determine
  bool given_up = false;              ///< no templates are awaited: spot positions alone count
  /// Why the camera cannot see the spots, or the tracker cannot separate them; empty: no known
  /// problem.
  std::string layout_fault;
  std::shared_ptr<const Reference> reference;  ///< the active one; null: no reference
  /// Why no frame can be valid, whatever the image. Without a plan: why none can be built; else
  /// without a reference: missing_reference_reason. An empty reason: it can.
  StatusMessage::SensorPart::Invalid obstacle;
  std::shared_ptr<const Calibration> calibration;  ///< the one that applies; null: none does
  std::shared_ptr<const ActiveSlm> slm;            ///< LUT and flatness; never null
};
using SensorView = std::shared_ptr<const SensorSnapshot>;

}  // namespace ovws
