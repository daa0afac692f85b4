#include "daemon/ovwsd/procedures/pupil_scan.hpp"

#include <cmath>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

// Probe diameter relative to a subaperture. A bright spot's peak scales with the diameter's fourth
// power. A vortex of charge 1 has 1/4 of a bright spot's peak, and a vortex of charge 2 has 1/10.
constexpr double kProbeDiameter = 0.7, kProbeDiameterHighCharge = 0.5;

ScanGrid grid_of(const SensorConfig& sensor, int rings) {
  const double part = std::abs(sensor.charge) <= 1 ? kProbeDiameter : kProbeDiameterHighCharge;
  return scan_grid(sensor.pupil_diameter_px,
                   part * sensor.pupil_diameter_px / sensor.subapertures_across, rings);
}

}  // namespace

Result<void> can_scan(const SensorSnapshot& now) {
  if (!now.registration) {
    return fail(Errc::refused, "", "no registration is active: call registration.run first");
  }
  if (!now.correction.empty()) {
    return fail(Errc::refused, "", "a correction is active: call correction.clear first");
  }
  return {};
}

PupilScan::PupilScan(Bench& bench, const SlmGeometry& slm, const SensorSnapshot& now, int frames,
                     int rings)
    : bench_(bench),
      probes_(bench, frames),
      base_cpp_(base_grating_cpp(now.sensor, slm)),
      fit_(grid_of(now.sensor, rings), px_per_cycle(now.optics, slm)) {
  const double subaperture_px = now.sensor.pupil_diameter_px / now.sensor.subapertures_across;
  spots_ = {0, lambda_d_px(now.optics, slm, now.sensor) * subaperture_px / probe_diameter_px(),
            lit_pixels(bench.camera().settings.pixel_format, now.optics.wavelength_nm)};
}

Result<PupilScan::Scan> PupilScan::scan(const std::vector<double>& error, double from, double to) {
  std::vector<double> shown(error.size(), 0.0);
  Probe probe{base_cpp_, 0, {}, probe_diameter_px(), {}};
  for (std::size_t k = 0; k < error.size(); ++k) {
    if (modes_j()[k] < kFirstSurfaceMode || error[k] == 0.0) continue;
    shown[k] = -error[k];
    probe.modes.push_back({modes_j()[k], shown[k]});
  }
  std::vector<std::optional<Vec2>> at_px;
  Vec2 sum;
  int seen = 0;
  for (const Vec2 centre : fit_.grid().centres_px) {
    probe.centre_px = centre;
    const auto light = probes_.light(probe);
    if (!light) return fail(light.error());
    const auto spot = probe_spot(*light, spots_);
    if (!spot) return fail(spot.error());
    at_px.push_back(*spot ? (*spot)->fine : std::nullopt);
    if (at_px.back()) {
      sum = sum + *at_px.back();
      ++seen;
    }
    const double done = double(at_px.size()) / double(fit_.grid().centres_px.size());
    bench_.report_progress(from + done * (to - from));
  }
  auto found = fit_.fit(at_px, shown);
  if (!found) return fail(found.error());
  return Scan{std::move(*found), (1.0 / seen) * sum};
}

}  // namespace ovws
