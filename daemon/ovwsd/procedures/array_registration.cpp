/// registration.run of a fixed array: lattice, pitch, rotation and lit lenslets from one image.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/port/clock.hpp"
#include "core/wavefront/lenslet_search.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

FoundArray array_of(const LensletMap& map, const LensletPupil& pupil, const Config& config) {
  const double magnification = map.pitch_px * config.optics.camera_pitch_um / config.array.pitch_um;
  const SensorConfig sensor =
      sensor_with(config, {magnification, map.rotation_deg, pupil.diameter_px, pupil.centres_px});
  return {sensor.lenslets, map.lit(), magnification, pupil.diameter_px, sensor.subapertures_across};
}

/// Whether more than one spot in ten has a saturated pixel; a few may be hot pixels.
bool is_saturated(const Image<float>& mean_dn, double pitch_px) {
  const auto saturated = std::count_if(mean_dn.pixels.begin(), mean_dn.pixels.end(),
                                       [](float value) { return !std::isfinite(value); });
  const double lenslets = double(mean_dn.pixels.size()) / (pitch_px * pitch_px);
  return double(saturated) > 0.1 * lenslets;
}

Result<Registration> array_at_this_exposure(Bench& bench, const Config& config, int frames) {
  const SensorView view = bench.sensor();
  const CameraSettings camera = bench.camera().settings;
  const auto mean = bench.picture(frames);
  if (!mean) return fail(mean.error());
  const double pitch_px = lenslet_pitch_px(config.array, config.optics);
  if (is_saturated(*mean, pitch_px)) return fail(saturated_spot());
  bench.report_progress(0.8);
  const SpotModel spots =
      spot_model(view->sensor, view->optics, config.slm.geometry, camera.pixel_format);
  const auto map = find_lenslets(*mean, {config.sensor.grid, pitch_px, spots});
  if (!map) return fail(map.error());
  std::optional<double> pupil_px;
  if (config.array.pupil_mm)
    pupil_px = 1e3 * *config.array.pupil_mm / config.array.pitch_um * map->pitch_px;
  const LensletPupil pupil = lenslet_pupil(*map, pupil_px);
  Registration found;
  found.array = array_of(*map, pupil, config);
  if (found.array.empty()) {
    return fail(Errc::refused, "camera",
                "no lit lenslet lies inside the pupil: enlarge the light, or set array.pupil_mm");
  }
  const double error_px = map->residual_px / std::sqrt(double(map->lit()));
  found.px_per_cycle = found.array.lenslets.px_per_cycle;
  found.base_px = pupil.centre_px + Vec2{double(camera.roi.x), double(camera.roi.y)};
  found.base_standard_error_px = {error_px, error_px};
  found.residual_px = map->residual_px;
  found.sights = map->lit();
  found.t_taken_ns = utc_ns();
  return found;
}

}  // namespace

Result<Registration> measure_array(Bench& bench, const Config& config, int frames) {
  return unsaturated(bench, [&] { return array_at_this_exposure(bench, config, frames); });
}

}  // namespace ovws
