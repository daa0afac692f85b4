#include "daemon/ovwsd/procedures/probes.hpp"

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr double kFlooded = 0.02;  // saturated share of an image, in which a spot may be lost

bool is_at_rim(const Image<float>& light, Vec2 at, double rim_px) {
  return at.x < rim_px || at.y < rim_px || at.x > light.width - 1.0 - rim_px ||
         at.y > light.height - 1.0 - rim_px;
}

/// True if a pixel near `at` is NaN: saturated pixels are NaN in a mean image.
bool is_saturated(const Image<float>& light, Vec2 at, double reach_px) {
  const int reach = int(std::ceil(reach_px)), cx = int(at.x), cy = int(at.y);
  for (int y = std::max(0, cy - reach); y < std::min(light.height, cy + reach + 1); ++y) {
    for (int x = std::max(0, cx - reach); x < std::min(light.width, cx + reach + 1); ++x) {
      if (std::isnan(light.at(x, y))) return true;
    }
  }
  return false;
}

/// True if more pixels are saturated than of a zeroth order in view.
bool is_flooded(const Image<float>& light) {
  const auto saturated =
      std::ranges::count_if(light.pixels, [](float dn) { return std::isnan(dn); });
  return double(saturated) > kFlooded * double(light.pixels.size());
}

// Probe diameter relative to a subaperture. A bright spot's peak scales with the diameter's fourth
// power. A vortex of charge 1 has 1/4 of a bright spot's peak, and a vortex of charge 2 has 1/10.
constexpr double kProbeDiameter = 0.7, kProbeDiameterHighCharge = 0.5;

ScanGrid grid_of(const SensorConfig& sensor, int rings) {
  const double part = std::abs(sensor.charge) <= 1 ? kProbeDiameter : kProbeDiameterHighCharge;
  return scan_grid(sensor.pupil_diameter_px,
                   part * sensor.pupil_diameter_px / sensor.subapertures_across, rings);
}

}  // namespace

Result<Image<float>> ProbeBench::light(const Probe& probe) {
  if (!without_) {
    const auto flat = [](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
      renderer.render(HologramKind::flat, {}, grey);
    };
    if (auto shown = bench_.show(flat); !shown) return fail(shown.error());
    auto without = bench_.picture(frames_);
    if (!without) return without;
    without_ = std::move(*without);
  }
  const auto paint = [probe](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
    renderer.render_probe(probe, grey);
  };
  if (auto shown = bench_.show(paint); !shown) return fail(shown.error());
  auto picture = bench_.picture(frames_);
  if (!picture) return picture;
  if (picture->width != without_->width || picture->height != without_->height) {
    return fail(Errc::refused, "camera",
                "the camera's region changed during the job; start it again");
  }
  for (std::size_t k = 0; k < picture->pixels.size(); ++k) {
    picture->pixels[k] -= without_->pixels[k];
  }
  return picture;
}

Result<std::optional<ProbeSpot>> probe_spot(const Image<float>& light, const SpotModel& spots) {
  const auto rough = spot_in(light, spots);
  if (!rough && is_flooded(light)) return fail(saturated_spot());
  if (!rough || is_at_rim(light, *rough, kProbeRim * spots.lambda_d_px)) {
    return std::optional<ProbeSpot>();
  }
  if (is_saturated(light, *rough, spots.lambda_d_px)) {
    return fail(saturated_spot());
  }
  return std::optional(ProbeSpot{*rough, find_probe(light, spots, *rough)});
}

Result<void> can_scan(const SensorSnapshot& now) {
  if (!now.registration) {
    return fail(Errc::refused, "", "no registration is active: call registration.run first");
  }
  if (!now.correction.empty()) {
    return fail(Errc::refused, "", "a correction is active: call correction.clear first");
  }
  return {};
}

PupilScan::PupilScan(Bench& bench, const SensorSnapshot& now, int frames, int rings)
    : bench_(bench),
      probes_(bench, frames),
      base_cpp_(base_grating_cpp(now.sensor, bench.geometry())),
      fit_(grid_of(now.sensor, rings), px_per_cycle(now.optics, bench.geometry())) {
  const double subaperture_px = now.sensor.pupil_diameter_px / now.sensor.subapertures_across;
  spots_ = {
      0,
      lambda_d_px(now.optics, bench.geometry(), now.sensor) * subaperture_px / probe_diameter_px(),
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
