/// A calibration: the interaction matrix that was measured on the bench, and what it belongs to.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"
#include "core/wavefront/interaction_matrix.hpp"
#include "core/wavefront/matrix_comparison.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"

namespace ovws {

/// What a calibration belongs to: with anything else its matrix means nothing.
struct CalibrationKey {
  ReferenceKey sensor;       ///< sensor, tracking and region
  PxPerCycle px_per_cycle;   ///< of the registration in force, or else of the configuration
  Vec2 base_px;              ///< pixels of the camera's sensor
  double lambda_d_px = 0.0;  ///< of a spot
  nlohmann::json camera;     ///< {vendor, model, serial}; null: not known
  nlohmann::json slm;        ///< see slm_identity; null: not known
};
CalibrationKey calibration_key(const ReferenceKey& sensor, const OpticsConfig& configured,
                               const SlmGeometry& slm,
                               const std::optional<Registration>& registration,
                               nlohmann::json camera);

/// Names of what differs: "charge", "roi", "tracker", "registration", "camera", … Registrations
/// count as the same as long as another run may give the one for the other: to 0.2 % of the scale,
/// and lambda/(4d) of the base. Empty: a calibration of the one serves the other.
std::vector<std::string> differences(const CalibrationKey& a, const CalibrationKey& b);

/// What a run measured.
struct MeasuredCalibration {
  double amplitude_waves = 0.0;  ///< asked for; single modes may have been pushed by less
  int frames = 0;                ///< of each picture
  std::int64_t t_taken_ns = 0;
  InteractionMatrix matrix;
  MatrixComparison comparison;
};

struct Calibration : MeasuredCalibration {
  CalibrationKey key;
  ModeOperator mode_operator;
  std::shared_ptr<const nlohmann::json> origin;  ///< see ReferenceBench; never null
  std::string sha256;                            ///< of the file that keeps it; empty: none does
};

}  // namespace ovws
