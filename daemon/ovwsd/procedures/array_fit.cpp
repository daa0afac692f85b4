/// array.fit: depth and shift of the spiral plates of a fixed array.
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {

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

Result<PlateFit> measure_plate(Bench& bench, const SlmGeometry& slm, int frames) {
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
