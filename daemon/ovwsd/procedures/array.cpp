/// Fixed arrays: `registration.run` finds lattice, pitch, rotation and lit lenslets in one image;
/// `array.fit` finds depth and shift of the spiral plates.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/lenslet_search.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {
namespace {

/// The lattice's rotation along the array's axes, at most half of its symmetry.
double rotation_on_array(double seen_deg, Grid grid, const PxPerCycle& direction) {
  const double seen = seen_deg * std::numbers::pi / 180.0;
  const Vec2 along = direction.back({std::cos(seen), std::sin(seen)});
  const double degrees = std::atan2(along.y, along.x) * 180.0 / std::numbers::pi;
  return std::remainder(degrees, grid == Grid::square ? 90.0 : 60.0);
}

/// The array that was found on the camera, along the axes of the array.
FoundArray array_of(const LensletMap& map, const LensletPupil& pupil, const Config& config) {
  const PxPerCycle direction = config.optics.registered.value_or(PxPerCycle(1.0));
  std::vector<Vec2> centres_px = pupil.centres_px;
  for (Vec2& centre : centres_px) centre = direction.back(centre);
  std::sort(centres_px.begin(), centres_px.end(),
            [](Vec2 a, Vec2 b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
  const SensorConfig sensor = sensor_with(
      config, {map.pitch_px, rotation_on_array(map.rotation_deg, config.sensor.grid, direction),
               pupil.diameter_px, std::move(centres_px)});
  return {sensor.lenslets, map.lit(), magnification_of(config, map.pitch_px), pupil.diameter_px,
          sensor.subapertures_across};
}

/// Standard error of `scale`, which grows with the square of the pitch on the camera. The direction
/// is that of the configuration, and has none.
PxPerCycle error_of(const PxPerCycle& scale, const LensletMap& map) {
  const double relative = 2.0 * map.pitch_error_px / map.pitch_px;
  return {relative * std::abs(scale.xx), relative * std::abs(scale.xy),
          relative * std::abs(scale.yx), relative * std::abs(scale.yy)};
}

/// Emits a warning event if the lenslets in use fill much less than the pupil.
void warn_of_dark_pupil(Bench& bench, const FoundArray& array, Grid grid) {
  constexpr double kLeastShare = 0.75;
  const double across = array.pupil_diameter_px / array.lenslets.width_px;
  const double cell = grid == Grid::hexagonal ? std::sqrt(0.75) : 1.0;
  const double share =
      double(array.lenslets.centres_px.size()) * cell / (0.25 * std::numbers::pi * across * across);
  if (share >= kLeastShare) return;
  bench.warn("registration",
             fmt::format("light fills only {:.0f} % of the pupil, so that fewer modes are measured "
                         "and their errors are larger: reduce array.pupil_mm, or set it to null",
                         100.0 * share),
             {{"share", share}});
}

Result<Registration> array_at_this_exposure(Bench& bench, int frames) {
  const Config& config = bench.config();
  const SensorView view = bench.sensor();
  const CameraSettings camera = bench.camera().settings;
  const auto mean = bench.picture(frames);
  if (!mean) return fail(mean.error());
  const double pitch_px = lenslet_pitch_px(config.array, config.optics);
  bench.report_progress(0.8);
  const SpotModel spots =
      spot_model(view->sensor, view->optics, config.slm.geometry, camera.pixel_format);
  const auto map = find_lenslets(*mean, {config.sensor.grid, pitch_px, spots});
  const int saturated = count_saturated_spots(*mean, pitch_px);
  if (!map) return fail(saturated >= int(kMinSubapertures) ? saturated_spot() : map.error());
  if (10 * saturated > map->lit()) return fail(saturated_spot());
  std::optional<double> pupil_px;
  if (config.array.pupil_mm)
    pupil_px = 1e3 * *config.array.pupil_mm / config.array.pitch_um * map->pitch_px;
  const LensletPupil pupil = lenslet_pupil(*map, pupil_px);
  Registration found;
  found.array = array_of(*map, pupil, config);
  if (found.array.empty() && pupil_px) {
    return fail(Errc::refused, "camera",
                "no lit lenslet lies inside the pupil: enlarge the light, or set array.pupil_mm");
  }
  if (found.array.empty()) {  // the pupil was sought among the lit lenslets
    return fail(Errc::refused, "sensor.grid",
                "no lit lenslets adjoin in the lattice that is configured: correct sensor.grid, or "
                "enlarge the light");
  }
  warn_of_dark_pupil(bench, found.array, config.sensor.grid);
  const double error_px = map->residual_px / std::sqrt(double(map->lit()));
  found.px_per_cycle = config.optics.registered.value_or(PxPerCycle(1.0))
                           .scaled_to(found.array.lenslets.px_per_cycle);
  found.standard_error = error_of(found.px_per_cycle, *map);
  found.base_px = pupil.centre_px + Vec2{double(camera.roi.x), double(camera.roi.y)};
  found.base_standard_error_px = {error_px, error_px};
  found.residual_px = map->residual_px;
  found.sights = map->lit();
  found.t_taken_ns = utc_ns();
  return found;
}

}  // namespace

Result<Registration> measure_array(Bench& bench, int frames) {
  return unsaturated(bench, [&] { return array_at_this_exposure(bench, frames); });
}

Result<void> can_fit_array(const SensorSnapshot& sensor) {
  if (sensor.sensor.lenslets.empty()) {
    return fail(Errc::refused, "",
                "the sensor has no lenslets: array.fit needs \"modulator\": \"fixed\"");
  }
  if (sensor.sensor.charge == 0) {
    return fail(Errc::refused, "sensor.charge", "bright lenslets (charge 0) have no spiral plates");
  }
  if (sensor.registration) return {};
  return fail(Errc::refused, "registration",
              "the array has not been found yet: call registration.run first");
}

Result<PlateFit> measure_plate(Bench& bench, int frames) {
  const SlmGeometry& slm = bench.geometry();
  const SensorView view = bench.sensor();
  if (auto can = can_fit_array(*view); !can) return fail(can.error());
  const auto taken = unsaturated(bench, [&] { return bench.reference(frames); });
  if (!taken) return fail(taken.error());
  if (!taken->picture) return fail(Errc::refused, "camera", "no frame with its image arrived");
  const double lambda_d_px = ovws::lambda_d_px(view->optics, slm, view->sensor);
  if (auto still = check_average(taken->average, kMaxMotion * lambda_d_px); !still) {
    return fail(still.error());
  }
  bench.report_progress(0.5);
  const LitPixels lit = lit_pixels(taken->settings.pixel_format, view->optics.wavelength_nm);
  return fit_plate(taken->picture->mean_dn, view->sensor, slm, view->optics, lit,
                   found_positions(taken->average), [&bench] { return bench.stopped(); });
}

}  // namespace ovws
