/// State of the sensor: everything that determines the hologram and how frames are measured. A
/// plain value with pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/lease/request_table.hpp"
#include "daemon/ovwsd/library/measured_registration.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// The configured optics and light sources. A registration replaces px_per_cycle and the centre.
struct BenchOptics {
  OpticsConfig optics;
  SlmGeometry slm;
  std::vector<BeamConfig> beams{};  ///< as configured
  nlohmann::json flatness_file{};   ///< flatness_sha256 of the configuration's map
  nlohmann::json array{};           ///< array_json
};

/// Spot templates of the tracker `fit`. The wavefront may drift away from their operating point:
/// every frame reports the drift.
struct ActiveTemplates {
  TemplatesKey made_for;
  std::shared_ptr<const FrameFit> fit;
  bool given_up = false;  ///< no templates will come soon: use spot positions instead
  friend bool operator==(const ActiveTemplates&, const ActiveTemplates&) = default;
};

struct SensorState : SensorShown {
  std::vector<Mode> correction;                        ///< subtracted from the hologram
  std::shared_ptr<const Image<std::uint8_t>> painted;  ///< image drawn by a job, for pattern `test`
  Roi roi;
  PixelFormat format = PixelFormat::mono8;
  std::optional<MeasuredRegistration> registration;  ///< pixels of the camera's whole sensor
  std::shared_ptr<const ActiveSlm> slm;              ///< never null
  std::shared_ptr<const HologramRenderer> renderer;  ///< draws holograms of `sensor` with `slm`
  /// Increases with every change that invalidates earlier measurements.
  std::uint64_t sensor_epoch = 1;
  Holder holder = Holder::nobody;
  ActiveTemplates templates;  ///< used if they are made for this state
};

/// Whether templates may measure frames: with the tracker `fit` unless a job has the sensor, with
/// another one only while the loop has it.
bool takes_templates(const SensorState& state);
/// Whether the hologram shown is a DMD's sequence of patterns.
bool shows_sequence(const SensorState& state);
/// The tracking of the plan: a sequence is measured by spot positions alone.
TrackingSettings tracking_in_use(const SensorState& state);
/// Zernike modes in the pattern of a sequence.
std::vector<Mode> pattern_modes(const SensorState& state, std::size_t pattern);
/// Zernike modes in the hologram shown, see shown_modes in core/optics/hologram.hpp.
std::vector<Mode> shown_modes(const SensorState& state);
/// Epoch of the hologram shown; 0 (nothing to measure) unless the pattern is `sensor`.
std::uint64_t shown_epoch(const SensorState& state);
/// Whether states `a` and `b` show the same hologram.
bool same_hologram(const SensorState& a, const SensorState& b);
/// Grey levels of the state's hologram: the job's image, or rendered now. Of a sequence: three
/// bytes a pixel, red, green and blue, whose bits are the patterns.
std::shared_ptr<const Image<std::uint8_t>> hologram_of(const SensorState& state);

/// Stops using the registration. The lenslets that it found are replaced by the `configured` ones.
void drop_registration(SensorState& state, const SensorConfig& configured);

/// Refuses (Errc::refused, field "registration") a fixed array that no registration has found: its
/// rotation is unknown, and a reference would give valid but wrong modes if it is turned.
Result<void> check_array_found(const SensorConfig& sensor, bool registered);
inline Result<void> check_array_found(const SensorState& state) {
  return check_array_found(state.sensor, state.registration.has_value());
}

/// The registration, converted from the base grating of its measurement to the current base
/// grating.
std::optional<Registration> registration_of(const SensorState& state, const BenchOptics& bench);
/// Optics in pixels of the camera's region of interest, with the registration, if there is one.
OpticsConfig optics_of(const SensorState& state, const BenchOptics& bench);
/// Spot positions of a flat wavefront, pixels of the camera's region.
std::vector<Vec2> model_positions(const SensorState& state, const BenchOptics& bench);
/// lambda/d, the scale of one spot, camera pixels.
double lambda_d_of(const SensorState& state, const BenchOptics& bench);

/// Replaces the renderer by one for the state's sensor and SLM. Errors: those of
/// HologramRenderer::make.
Result<void> renew_renderer(SensorState& state);
/// Checks the modes shown. Errors: the SLM's pixels cannot sample the modes' phase (Nyquist).
Result<void> check_sampling(const SensorState& state);
/// Checks the spot layout. Errors: neighbouring spots are too close for the tracker, or the spots
/// do not determine as many modes as requested.
Result<void> check_spots(const SensorState& state, const BenchOptics& bench);
/// Checks that no further light source overlaps another one. Errors: those of check_beams.
Result<void> check_sources_apart(const SensorState& state, const BenchOptics& bench);
/// Checks spots and camera region. Errors: those of check_spots; too many spots fall outside the
/// camera's region.
Result<void> check_layout(const SensorState& state, const BenchOptics& bench);

}  // namespace ovws
