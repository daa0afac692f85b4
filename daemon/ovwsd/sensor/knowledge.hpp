/// What was measured of this bench and is known now, and what of it belongs to a state of the
/// sensor.
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

/// A value; copies share what they hold.
struct Knowledge {
  std::vector<std::shared_ptr<const Reference>> references;      ///< oldest first
  std::vector<std::shared_ptr<const Calibration>> calibrations;  ///< oldest first
  std::optional<CameraInfo> camera;                              ///< none: not known
  /// Diffractive operators that were made: a cache, shared by all copies.
  std::shared_ptr<OperatorShelf> operators = std::make_shared<OperatorShelf>();
};

/// What belongs to a state.
struct Bound {
  std::shared_ptr<const Reference> reference;
  std::shared_ptr<const Calibration> calibration;
  std::shared_ptr<const ModeOperator> mode_operator;  ///< that is asked for; null: the slopes
};
Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench);

CalibrationKey calibration_key(const SensorState& state, const Knowledge& knowledge,
                               const BenchOptics& bench);
/// The one taken last that belongs to the state; null: none does.
std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench);
OperatorKey operator_key(const SensorState& state, const BenchOptics& bench);

/// Whether the reference is of this state's sensor, tracking and region, of its camera as far as
/// that is known, and of its SLM.
bool is_for(const Reference& reference, const SensorState& state, const Knowledge& knowledge);
/// Why a reference of this state's sensor, tracking and region does not belong to it; empty: it
/// does, or it is of another sensor.
std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench);
/// Why no calibration belongs to the state, by what the likeliest one lacks, and the way out.
std::string missing_calibration_reason(const SensorState& state, const Knowledge& knowledge,
                                       const BenchOptics& bench);

/// In place of those that belong to the same; returns these. Of old ones the picture is forgotten.
std::vector<std::shared_ptr<const Reference>> replace_reference(Knowledge& knowledge,
                                                                const SensorState& state,
                                                                Reference reference);
std::vector<std::shared_ptr<const Reference>> remove_references(Knowledge& knowledge,
                                                                const SensorState& state);
/// More of them, found again.
void add_references(Knowledge& knowledge, std::vector<std::shared_ptr<const Reference>> more);

// The same of calibrations.
std::vector<std::shared_ptr<const Calibration>> replace_calibration(Knowledge& knowledge,
                                                                    Calibration calibration);
std::vector<std::shared_ptr<const Calibration>> remove_calibrations(Knowledge& knowledge,
                                                                    const CalibrationKey& key);
void add_calibrations(Knowledge& knowledge, std::vector<std::shared_ptr<const Calibration>> more);

/// The checksum of the file that keeps what was taken then.
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
