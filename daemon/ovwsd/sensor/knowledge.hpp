/// The references, calibrations and operators that are loaded, and which of them apply to a sensor
/// state.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "daemon/ovwsd/sensor/mode_operators.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// All loaded measurements, as a value. Copies are cheap, because they share the items.
struct Knowledge {
  std::vector<std::shared_ptr<const Reference>> references;      ///< oldest first
  std::vector<std::shared_ptr<const Calibration>> calibrations;  ///< oldest first
  std::optional<CameraInfo> camera;                              ///< none: unknown
  /// Cache of diffractive operators, shared by all copies of this object.
  std::shared_ptr<LastOperators> diffractive = std::make_shared<LastOperators>();
};

/// The reference, calibration and mode operator (matrix from displacements to modes) that are valid
/// for one sensor state.
struct Bound {
  std::shared_ptr<const Reference> reference;
  std::shared_ptr<const Calibration> calibration;
  std::shared_ptr<const ModeOperator> mode_operator;  ///< as requested; null: slope_operator
  /// Why slope_operator replaces the requested operator, and what to do; empty: it does not.
  std::string operator_reason;
};
/// Selects what applies to the state. Computes a diffractive operator if one is requested and not
/// cached: that takes seconds.
Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench);

ReferenceKey reference_key(const SensorState& state);
CalibrationKey calibration_key(const SensorState& state, const Knowledge& knowledge,
                               const BenchOptics& bench);
/// The latest calibration that applies to the state; null: no calibration applies.
std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench);

/// Whether the reference was taken with this state's sensor, tracking, region, LUT and flatness,
/// and with this camera. An unknown camera counts as equal; for a model reference LUT and
/// flatness do not matter.
bool is_for(const Reference& reference, const SensorState& state, const Knowledge& knowledge);
/// Why a reference of this state's sensor and tracking cannot be used. Empty if it can be used, or
/// if it is another sensor's: then the settings were chosen.
std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench);
/// What to do about it.
inline constexpr std::string_view kUnusedRemedy = "take a new reference";
/// Which loaded reference of this state's sensor and tracking is not used, and why; the newest of
/// them. Empty: there is none. For a state without a reference.
std::string missing_reference_reason(const SensorState& state, const Knowledge& knowledge,
                                     const BenchOptics& bench);
/// Why no calibration applies to the state. Takes the loaded calibration with the fewest
/// differences from the state, and names these differences.
std::string missing_calibration_reason(const SensorState& state, const Knowledge& knowledge,
                                       const BenchOptics& bench);

/// Adds a reference and returns the references that it replaces. To save memory, only the latest
/// eight references keep their mean image.
std::vector<std::shared_ptr<const Reference>> replace_reference(Knowledge& knowledge,
                                                                const SensorState& state,
                                                                Reference reference);
/// Removes the references that apply to the state, and returns them.
std::vector<std::shared_ptr<const Reference>> remove_references(Knowledge& knowledge,
                                                                const SensorState& state);
/// Adds references that were loaded from files.
void add_references(Knowledge& knowledge, std::vector<std::shared_ptr<const Reference>> more);

// Calibrations: add and replace, remove, and add from files, as for references above.
std::vector<std::shared_ptr<const Calibration>> replace_calibration(Knowledge& knowledge,
                                                                    Calibration calibration);
std::vector<std::shared_ptr<const Calibration>> remove_calibrations(Knowledge& knowledge,
                                                                    const CalibrationKey& key);
void add_calibrations(Knowledge& knowledge, std::vector<std::shared_ptr<const Calibration>> more);

/// Sets the checksum of the file of the item that was taken at `t_taken_ns` (UTC).
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
