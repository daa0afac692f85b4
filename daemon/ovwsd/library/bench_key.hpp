/// The bench that a measurement was made on, and whether the measurement applies to the bench as it
/// is now.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/optics/geometry.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/registration.hpp"

namespace ovws {

/// Everything that a measurement of any kind may depend on.
struct BenchKey {
  SensorConfig sensor;
  TrackingSettings tracking;
  Roi roi;
  nlohmann::json optics;         ///< as configured
  nlohmann::json slm;            ///< slm_identity: geometry, and checksums of LUT and flatness
  nlohmann::json camera;         ///< camera_json; null: unknown
  nlohmann::json flatness_file;  ///< SHA-256 of the map of slm.flatness; null: no map
  nlohmann::json array;          ///< array_json; null: the sensor has an SLM
  PxPerCycle px_per_cycle;       ///< by the registration, else by the configuration
  Vec2 base_px;                  ///< base spot by the same, pixels of the camera's whole sensor
};

/// Sets px_per_cycle and base_px by the registration (rebased to the key's sensor) or, without one,
/// by the configured optics. Call it when sensor and roi are set.
void use_map(BenchKey& key, const std::optional<Registration>& registration,
             const OpticsConfig& configured, const SlmGeometry& slm);
/// The configured optics with the key's map, in pixels of its region.
OpticsConfig optics_of(const BenchKey& key, OpticsConfig configured);

/// Vendor, model and serial number of the camera as JSON; null: the camera is unknown.
nlohmann::json camera_json(const std::optional<CameraInfo>& camera);

/// What the configuration says of a fixed array, and a registration measures or builds on; null:
/// the sensor has an SLM.
nlohmann::json array_json(const Config& config);

/// Tracking by spot positions alone: `lg` in place of `fit`, because both find equal positions.
TrackingSettings by_positions(TrackingSettings tracking);
/// Tracking settings that the positions of spots depend on (by_positions); all others are set to
/// constants: operator, mode count and estimates.
TrackingSettings position_tracking(const TrackingSettings& tracking);
/// Tracking settings that a calibration depends on: those of position_tracking, and with tracker
/// `fit` also `fit` itself and its mode count. A calibration with `fit` measures spot shapes, too,
/// for as many modes as requested.
TrackingSettings calibrated_tracking(const TrackingSettings& tracking);

/// Respects in which benches differ, and on which kinds of measurements depend.
namespace respect {
using Set = std::uint32_t;
constexpr Set kSensor = 1;
constexpr Set kPositions = 2;       ///< position_tracking
constexpr Set kShapes = 4;          ///< calibrated_tracking
constexpr Set kRoi = 8;             ///< the camera's region
constexpr Set kOptics = 16;         ///< all of the optics
constexpr Set kWavelength = 32;     ///< of the optics
constexpr Set kImaging = 64;        ///< focal length, magnification and camera pitch of the optics
constexpr Set kSlm = 128;           ///< the SLM's geometry
constexpr Set kLevels = 256;        ///< the SLM's LUT and flatness
constexpr Set kFlatnessFile = 512;  ///< the map of slm.flatness
constexpr Set kCamera = 1024;       ///< an unknown camera is equal to any
constexpr Set kPlaces = 2048;       ///< expected positions, within kPositionTolerance
constexpr Set kMap = 4096;          ///< the registration, within its repeatability
constexpr Set kArray = 8192;        ///< the array, as configured
/// What another setting of the sensor changes on purpose.
constexpr Set kChosen = kSensor | kPositions | kShapes;
/// What stays the same while the daemon runs.
constexpr Set kFixed = kOptics | kWavelength | kImaging | kSlm | kFlatnessFile;

// Kinds of measurements.
constexpr Set kModelReference = kSensor | kPositions | kRoi | kOptics | kSlm | kCamera;
constexpr Set kReference = kModelReference | kLevels | kPlaces;
constexpr Set kCalibration = kSensor | kShapes | kRoi | kOptics | kSlm | kLevels | kCamera | kMap;
constexpr Set kRegistration = kSlm | kCamera;
/// Settings that a registration builds on: if they have changed, it is used, with a warning.
constexpr Set kRegistrationSettings = kOptics | kArray;
constexpr Set kLut = kSlm | kWavelength;
constexpr Set kFlatness = kSlm | kWavelength | kImaging | kFlatnessFile | kCamera;
}  // namespace respect

/// Spots closer than this count as at the same position, lambda/d.
constexpr double kPositionTolerance = 0.25;

/// The respects of `of` in which a measurement made on `then` does not apply to `now`; 0: it
/// applies. Registrations count as equal within the repeatability of registration.run: 0.2 % of the
/// scale, and kPositionTolerance at the base spot (compared for equal regions only: without a
/// registration the base spot moves with the region).
respect::Set differing(respect::Set of, const BenchKey& then, const BenchKey& now);
/// Largest distance between the spots of the sensor `now` by the maps of both, camera pixels, and
/// lambda/d, the scale of one spot, by the map of `now`. Infinite: no lattice can be made.
struct Displacement {
  double farthest_px = 0.0, lambda_d_px = 0.0;
};
Displacement displacement(const BenchKey& then, const BenchKey& now);
/// Words for these respects: "sensor.charge was 1, and is 0; camera.roi.x was 0, and is 16". A
/// missing key counts as null. Empty: none.
std::string words_of(respect::Set differing, const BenchKey& then, const BenchKey& now);
/// Whether the differing respects were chosen: another sensor is in use. The lenslets of an array
/// are not chosen, but measured.
bool is_by_choice(respect::Set differing, const BenchKey& then, const BenchKey& now);

}  // namespace ovws
