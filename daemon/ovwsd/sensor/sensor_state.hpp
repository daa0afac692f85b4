/// The sensor's state: all that decides what is shown and how a frame is measured. A value, and
/// what follows from it alone.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/sensor/registration_file.hpp"
#include "daemon/ovwsd/sensor/torn_spots.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"

namespace ovws {

/// As configured; a registration takes the place of a part of it.
struct BenchOptics {
  OpticsConfig optics;
  SlmGeometry slm;
};

struct SensorState {
  SensorConfig sensor;
  TrackingSettings tracking;
  HologramKind pattern = HologramKind::sensor;
  std::vector<Mode> aberration;                        ///< shown on purpose, RMS-normalised waves
  std::vector<Mode> correction;                        ///< subtracted from the hologram
  std::shared_ptr<const Image<std::uint8_t>> painted;  ///< of pattern `test`
  Roi roi;
  PixelFormat format = PixelFormat::mono8;
  std::optional<MeasuredRegistration> registration;  ///< pixels of the camera's sensor
  std::shared_ptr<const SlmInForce> slm;             ///< never null
  std::shared_ptr<const HologramRenderer> renderer;  ///< of `sensor` and `slm`
  /// Changes with whatever makes what was measured before mean nothing.
  std::uint64_t sensor_epoch = 1;
  std::optional<TornSpots>
      torn;  ///< spots that are followed by the shapes the wavefront gives them
};

/// What is added to the pattern: the aberration less the correction. The corrected beam, for which
/// the grating is shown, has no aberration of ours.
std::vector<Mode> shown_modes(const SensorState& state);
/// 0, nothing to measure, unless the picture is the sensor's.
std::uint64_t shown_epoch(const SensorState& state);
/// Whether both show the same picture.
bool same_picture(const SensorState& a, const SensorState& b);
std::shared_ptr<const Image<std::uint8_t>> picture_of(const SensorState& state);

/// The registration with the base of the sensor that is shown, whatever it was measured with.
std::optional<Registration> registration_of(const SensorState& state, const BenchOptics& bench);
/// In the camera's region: as configured, or as registered.
OpticsConfig optics_of(const SensorState& state, const BenchOptics& bench);
/// Where spots are expected without aberrations, pixels of the camera's region.
std::vector<Vec2> model_positions(const SensorState& state, const BenchOptics& bench);
/// lambda/d, the scale of one spot, camera pixels.
double lambda_d_of(const SensorState& state, const BenchOptics& bench);

/// Draws with the state's own sensor and SLM from now on. Errors: as of HologramRenderer::make.
Result<void> renew_renderer(SensorState& state);
/// Errors: the SLM cannot show these modes.
Result<void> check_sampling(const SensorState& state);
/// Errors: neighbouring spots are too close for the tracker.
Result<void> check_apart(const SensorState& state, const BenchOptics& bench);
/// Errors: that, or the camera does not see the spots.
Result<void> check_layout(const SensorState& state, const BenchOptics& bench);

}  // namespace ovws
