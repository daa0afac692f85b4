#include "daemon/ovwsd/procedures/measurements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/probes.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr double kReach = 0.7;  // fraction of the field that the sensor's spots occupy
// Limits of the fit residual, lambda/d: for tracker positions and for intensity centres.
constexpr double kMaxFineResidual = 0.02, kMaxRoughResidual = 0.1;
constexpr std::size_t kMaxOutliers = 2;  // dropped positions, which may be ghosts
constexpr double kMaxScaleError = 0.03;  // relative; if exceeded, locate the spots at the new scale

/// Grating steps around the base grating, in units of the reach. Three steps are repeated at the
/// end to reveal motion of the bench.
constexpr std::array<Vec2, 12> kSteps{{{0, 0},
                                       {1, 0},
                                       {-1, 0},
                                       {0, 1},
                                       {0, -1},
                                       {1, 1},
                                       {-1, -1},
                                       {1, -1},
                                       {-1, 1},
                                       {0, 0},
                                       {1, 0},
                                       {0, 1}}};

struct Look {
  Vec2 offset_cpp;
  Image<float> light;  ///< image minus the image without the probe, DN
};

double reach_cpp(const Lattice& lattice, Vec2 base_cpp) {
  double most = 0.0;
  for (const Subaperture& s : lattice.subapertures) {
    most = std::max(most, norm(s.frequency_cpp - base_cpp));
  }
  // Diagonal steps are longer by sqrt(2).
  const double free = kNyquistCpp - std::max(std::abs(base_cpp.x), std::abs(base_cpp.y));
  return std::min(kReach * most / std::sqrt(2.0), free);
}

/// Leaves the light of the main source.
void darken_outside(const Disc& region, Image<float>& light) {
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      if (!region.contains({double(x), double(y)})) light.at(x, y) = 0.0F;
    }
  }
}

Result<std::vector<Look>> looks_at_steps(Bench& bench, Vec2 base_cpp, double reach, int charge,
                                         int frames) {
  ProbeBench probes(bench, frames);
  std::vector<Look> looks;
  for (const Vec2 step : kSteps) {
    const Vec2 offset = reach * step;
    auto light = probes.light({base_cpp + offset, charge});
    if (!light) return fail(light.error());
    if (const auto& own = bench.sensor()->region) darken_outside(*own, *light);
    looks.push_back({offset, std::move(*light)});
    bench.report_progress(double(looks.size()) / (kSteps.size() + 1));
  }
  return looks;
}

/// Positions of the probe: intensity centres (rough) and tracker positions (fine).
struct Sights {
  std::vector<ProbeSight> rough, fine;
};
Result<Sights> sights_of(const Bench& bench, const std::vector<Look>& looks,
                         const SpotModel& spots) {
  Sights sights;
  for (const Look& one : looks) {
    if (bench.stopped()) return fail(Errc::refused, "", "the job was stopped");
    const auto spot = probe_spot(one.light, spots);
    if (!spot) return fail(spot.error());
    if (!*spot) continue;
    sights.rough.push_back({one.offset_cpp, (*spot)->rough});
    if ((*spot)->fine) sights.fine.push_back({one.offset_cpp, *(*spot)->fine});
  }
  return sights;
}

double distance_px(const Registration& map, const ProbeSight& sight) {
  return norm(sight.at_px - (map.base_px + map.px_per_cycle * sight.offset_cpp));
}

/// Fits the affine map. Drops up to kMaxOutliers of the worst positions, which may be ghosts.
Result<Registration> fit_without_outliers(std::vector<ProbeSight> sights, double max_residual_px) {
  for (std::size_t outliers = 0;; ++outliers) {
    const auto map = fit_registration(sights);
    if (!map || map->residual_px < max_residual_px) return map;
    if (outliers == kMaxOutliers) {
      return fail(
          Errc::refused, "",
          fmt::format("the spot does not move as an affine map predicts (residual {:.2f} px "
                      "RMS): check that light reaches the camera, that nothing else moves on the "
                      "bench, that the spot is not saturated, and that the region of interest "
                      "contains the sensor's field",
                      map->residual_px));
    }
    sights.erase(std::max_element(sights.begin(), sights.end(), [&](const auto& a, const auto& b) {
      return distance_px(*map, a) < distance_px(*map, b);
    }));
  }
}

/// Fits the map to tracker positions, or to intensity centres if the tracker lost a spot. Under a
/// strong aberration only the intensity centre is reliable.
Result<Registration> map_of(const Bench& bench, const std::vector<Look>& looks,
                            const SpotModel& spots) {
  const auto sights = sights_of(bench, looks, spots);
  if (!sights) return fail(sights.error());
  if (sights->fine.size() < sights->rough.size()) {
    return fit_without_outliers(sights->rough, kMaxRoughResidual * spots.lambda_d_px);
  }
  return fit_without_outliers(sights->fine, kMaxFineResidual * spots.lambda_d_px);
}

Result<Registration> registration_at_this_exposure(Bench& bench, int frames) {
  const SlmGeometry& slm = bench.geometry();
  const SensorView view = bench.sensor();
  const SensorSnapshot& now = *view;
  const CameraSettings camera = bench.camera().settings;
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const Vec2 base_cpp = base_grating_cpp(now.sensor, slm);
  const int charge = std::clamp(now.sensor.charge, -kMaxProbeCharge, kMaxProbeCharge);
  const auto looks = looks_at_steps(bench, base_cpp, reach_cpp(*lattice, base_cpp), charge, frames);
  if (!looks) return fail(looks.error());
  SpotModel spots{charge, lambda_d_px(now.optics, slm, now.sensor),
                  lit_pixels(camera.pixel_format, now.optics.wavelength_nm)};
  auto map = map_of(bench, *looks, spots);
  if (!map) return map;
  const double ratio = map->px_per_cycle.scale() / camera_px_per_cycle(now.optics, slm);
  if (std::abs(ratio - 1.0) > kMaxScaleError) {
    spots.lambda_d_px *= ratio;
    map = map_of(bench, *looks, spots);
    if (!map) return map;
  }
  map->t_taken_ns = utc_ns();
  map->base_cpp = base_cpp;
  map->base_px = map->base_px + Vec2{double(camera.roi.x), double(camera.roi.y)};
  return map;
}

}  // namespace

Result<Registration> measure_registration(Bench& bench, int frames) {
  return unsaturated(bench, [&] { return registration_at_this_exposure(bench, frames); });
}

}  // namespace ovws
