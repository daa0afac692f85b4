/// The references, calibrations and operators that are loaded, and which of them apply to a sensor
/// state.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// Value type. Copies are cheap: they share the items.
struct Knowledge {
  std::vector<std::shared_ptr<const Reference>> references;      ///< oldest first
  std::vector<std::shared_ptr<const Calibration>> calibrations;  ///< oldest first
  std::optional<CameraInfo> camera;                              ///< none: unknown
  /// Shared by all copies.
  std::shared_ptr<LastOperators> diffractive = std::make_shared<LastOperators>();
};

/// The reference, calibration and operator that apply to a state.
struct Bound {
  std::shared_ptr<const Reference> reference;
  std::shared_ptr<const Calibration> calibration;
  std::shared_ptr<const ModeOperator> mode_operator;  ///< as requested; null: use slope_operator
  std::string operator_reason;  ///< why slope_operator is used instead of the requested; or empty
};
/// Makes a diffractive operator if it is requested and the last one is another.
Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench);

CalibrationKey calibration_key(const SensorState& state, const Knowledge& knowledge,
                               const BenchOptics& bench);
/// The latest calibration that applies to the state; null: none.
std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench);

/// Whether the reference was taken with this state's sensor, tracking, region and SLM, and with the
/// same camera, if both cameras are known.
bool is_for(const Reference& reference, const SensorState& state, const Knowledge& knowledge);
/// Why a reference with this state's sensor, tracking and region cannot be used. Empty: it can, or
/// it was taken with another sensor, tracking or region.
std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench);
/// Why no calibration applies to the state, and what to do. Names the differences of the
/// calibration that has the fewest.
std::string missing_calibration_reason(const SensorState& state, const Knowledge& knowledge,
                                       const BenchOptics& bench);

/// Adds a reference and returns the ones that it replaces. Only the latest eight references keep
/// their mean image in memory.
std::vector<std::shared_ptr<const Reference>> replace_reference(Knowledge& knowledge,
                                                                const SensorState& state,
                                                                Reference reference);
std::vector<std::shared_ptr<const Reference>> remove_references(Knowledge& knowledge,
                                                                const SensorState& state);
/// Adds references that were loaded from files.
void add_references(Knowledge& knowledge, std::vector<std::shared_ptr<const Reference>> more);

// The same for calibrations.
std::vector<std::shared_ptr<const Calibration>> replace_calibration(Knowledge& knowledge,
                                                                    Calibration calibration);
std::vector<std::shared_ptr<const Calibration>> remove_calibrations(Knowledge& knowledge,
                                                                    const CalibrationKey& key);
void add_calibrations(Knowledge& knowledge, std::vector<std::shared_ptr<const Calibration>> more);

/// Sets the file checksum of the item that was taken at `t_taken_ns`.
template <class T>
void set_checksum(std::vector<std::shared_ptr<const T>>& all, std::int64_t t_taken_ns,
                  const std::string& sha256) {
  for (auto& one : all) {
    if (one->t_taken_ns != t_taken_ns) continue;
    auto with_file = std::make_shared<T>(*one);
    with_file->sha256 = sha256;
    one = std::move(with_file);
  }
}

}  // namespace ovws
