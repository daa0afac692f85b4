/// Calibration: the measured interaction (poke) matrix, and the bench and settings that it is valid
/// for.
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

/// Everything that a calibration depends on. If any field differs from the present sensor's, the
/// calibration's matrix must not be used.
struct CalibrationKey {
  ReferenceKey sensor;       ///< sensor, tracking and region of interest
  PxPerCycle px_per_cycle;   ///< by the active registration, else by the configuration
  Vec2 base_px;              ///< base spot, pixels of the camera's whole sensor
  double lambda_d_px = 0.0;  ///< lambda/d, the scale of one spot, camera pixels
  nlohmann::json camera;     ///< {vendor, model, serial}; null: unknown
  nlohmann::json slm;        ///< identity of the SLM (slm_identity); null: unknown
};
CalibrationKey calibration_key(const ReferenceKey& sensor, const OpticsConfig& configured,
                               const SlmGeometry& slm,
                               const std::optional<Registration>& registration,
                               nlohmann::json camera);

/// Spots closer than this count as at the same position, lambda/d.
constexpr double kPositionTolerance = 0.25;

/// Names of the fields in which the keys differ: "charge", "roi", "tracker", "registration",
/// "camera", … Empty: a calibration with key `a` is valid for a sensor with key `b`. Registrations
/// count as equal within the repeatability of registration.run: 0.2 % of the scale, and lambda/(4d)
/// at the base spot. An unknown camera or SLM counts as equal.
std::vector<std::string> differences(const CalibrationKey& a, const CalibrationKey& b);

/// Result of calibration.run, or a matrix of calibration.set.
struct MeasuredCalibration {
  double amplitude_waves = 0.0;  ///< requested poke; some modes may have been poked by less
  int frames = 0;                ///< number of frames averaged for each hologram
  std::int64_t t_taken_ns = 0;
  InteractionMatrix matrix;
  MatrixComparison comparison;
  std::vector<int> unsteady_j{};  ///< modes whose response differed from poke to poke
  std::shared_ptr<const MeasuredShapes> shapes;  ///< null unless the tracker is `fit`
};

/// Mode operator of kind `measured`, made from the calibration's poke matrix.
ModeOperator mode_operator_of(const MeasuredCalibration& measured);

struct Calibration : MeasuredCalibration {
  CalibrationKey key;
  ModeOperator mode_operator;
  std::shared_ptr<const nlohmann::json> origin;  ///< see ReferenceBench; never null
  std::string sha256;  ///< checksum of the calibration's file; empty: not stored
};

}  // namespace ovws
