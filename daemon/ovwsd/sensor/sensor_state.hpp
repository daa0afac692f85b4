/// State of the sensor: everything that determines the hologram and how frames are measured. A
/// plain value with pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/sensor/active_templates.hpp"
#include "daemon/ovwsd/sensor/registration_file.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"

namespace ovws {

/// The configured optics. A registration replaces a part of them.
struct BenchOptics {
  OpticsConfig optics;
  SlmGeometry slm;
};

struct SensorState : SensorShown {
  std::vector<Mode> correction;                        ///< subtracted from the hologram
  std::shared_ptr<const Image<std::uint8_t>> painted;  ///< image of a job, for pattern `test`
  Roi roi;
  PixelFormat format = PixelFormat::mono8;
  std::optional<MeasuredRegistration> registration;  ///< pixels of the camera's whole sensor
  std::shared_ptr<const ActiveSlm> slm;              ///< never null
  std::shared_ptr<const HologramRenderer> renderer;  ///< draws holograms of `sensor` with `slm`
  /// Increases with every change that invalidates earlier measurements.
  std::uint64_t sensor_epoch = 1;
  bool by_positions = false;  ///< a job measures: positions count, which come from one tracker
  ActiveTemplates templates;  ///< used where they belong to epoch and reference
};

/// Modes of the hologram shown, see shown_modes in core/optics/hologram.hpp.
std::vector<Mode> shown_modes(const SensorState& state);
/// Epoch of the hologram shown; 0 (nothing to measure) unless the pattern is `sensor`.
std::uint64_t shown_epoch(const SensorState& state);
/// Whether both states show the same hologram.
bool same_hologram(const SensorState& a, const SensorState& b);
std::shared_ptr<const Image<std::uint8_t>> hologram_of(const SensorState& state);

/// The registration, converted from the base grating that it was measured with to the current one.
std::optional<Registration> registration_of(const SensorState& state, const BenchOptics& bench);
/// Optics relative to the camera's region of interest, registered if there is a registration.
OpticsConfig optics_of(const SensorState& state, const BenchOptics& bench);
/// Spot positions of a flat wavefront, pixels of the camera's region.
std::vector<Vec2> model_positions(const SensorState& state, const BenchOptics& bench);
/// lambda/d, the scale of one spot, camera pixels.
double lambda_d_of(const SensorState& state, const BenchOptics& bench);

/// Replaces the renderer by one for the state's sensor and SLM. Errors: those of
/// HologramRenderer::make.
Result<void> renew_renderer(SensorState& state);
/// Errors: the SLM's pixels cannot sample the phase of these modes.
Result<void> check_sampling(const SensorState& state);
/// Errors: neighbouring spots are too close for the tracker, or do not determine as many modes as
/// are requested.
Result<void> check_spots(const SensorState& state, const BenchOptics& bench);
/// Errors: those of check_spots; too many spots fall outside the camera's region.
Result<void> check_layout(const SensorState& state, const BenchOptics& bench);

}  // namespace ovws
