/// The references and calibrations that are loaded, and which of them apply to a sensor
/// state.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/port/camera.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/library/items.hpp"
#include "daemon/ovwsd/sensor/sensor_state.hpp"

namespace ovws {

/// All loaded measurements, as a value. Copies are cheap, because they share the items.
struct Knowledge {
  Shared<Reference> references;
  Shared<Calibration> calibrations;
  std::optional<CameraInfo> camera;  ///< none: unknown
};
template <class T>
inline constexpr Shared<T> Knowledge::*kLoaded = nullptr;
template <>
inline constexpr auto kLoaded<Reference> = &Knowledge::references;
template <>
inline constexpr auto kLoaded<Calibration> = &Knowledge::calibrations;

/// The reference, calibration and mode operator (matrix from displacements to modes) that are valid
/// for one sensor state.
struct Bound {
  std::shared_ptr<const Reference> reference;
  std::shared_ptr<const Calibration> calibration;
  std::shared_ptr<const ModeOperator> mode_operator;  ///< as requested; null: slope_operator
  /// Why slope_operator replaces the requested operator, and what to do; empty: it does not.
  std::string operator_reason;
};
/// Selects what applies to the state.
Bound bind(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench);
/// What templates for the state are made for.
TemplatesKey templates_key(const SensorState& state, const Bound& bound);

/// The bench as it is, for `differing`.
BenchKey key_of(const SensorState& state, const Knowledge& knowledge, const BenchOptics& bench);
/// The latest calibration that applies to the state; null: no calibration applies.
std::shared_ptr<const Calibration> calibration_for(const SensorState& state,
                                                   const Knowledge& knowledge,
                                                   const BenchOptics& bench);

/// Why a reference cannot be used for this state; empty: it can be used. `by_choice`: also if
/// another sensor or tracker was chosen; false: the reason is then empty, too.
std::string unused_reason(const Reference& reference, const SensorState& state,
                          const Knowledge& knowledge, const BenchOptics& bench, bool by_choice);
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

/// Adds references or calibrations as the latest; the oldest make room, as on the disk. To save
/// memory, only the latest eight references keep their mean image.
template <class T>
void add_items(Knowledge& knowledge, const Shared<T>& more);
/// Removes the references or calibrations that a new one for this state replaces, and returns them.
template <class T>
Shared<T> remove_items(Knowledge& knowledge, const SensorState& state, const BenchOptics& bench);

}  // namespace ovws
