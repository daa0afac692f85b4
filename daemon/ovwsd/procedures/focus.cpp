#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/pixels.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovwsd/fitter/spots_model.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/probes.hpp"

namespace ovws {
namespace {

constexpr int kLastFocusMode = 14;  // of the result
constexpr int kDefocus = 4;

/// The modes that the places of the spots determine, whatever the plan measures.
Result<std::vector<int>> determined_modes(const SensorSnapshot& now, const SlmGeometry& slm) {
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  std::vector<int> modes_j =
      slope_operator(*lattice, now.sensor, now.tracking, px_per_cycle(now.optics, slm)).modes_j;
  std::erase_if(modes_j, [](int j) { return j > kLastFocusMode; });
  if (std::ranges::find(modes_j, kDefocus) != modes_j.end()) return modes_j;
  return fail(Errc::refused, "sensor.subapertures_across",
              "the spots do not determine defocus: use more subapertures");
}

/// The sensor as it is seen now: its spots and their mean image in place of its reference.
SensorSnapshot seen_by(const SensorSnapshot& sensor, std::vector<int> modes_j,
                       const SpotAverage& spots, Image<float> mean_dn,
                       const CameraSettings& camera) {
  constexpr int kOwnNoise = 1;  // frames: the noise is read from the mean image itself
  Reference reference;
  reference.positions_px = found_positions(spots);
  reference.picture = std::make_shared<const ReferenceImage>(ReferenceImage{
      kOwnNoise, camera.gain_db, camera.gain_raw, camera.pixel_format, std::move(mean_dn)});
  SensorSnapshot seen = sensor;
  seen.modes_j = seen.position_modes_j = std::move(modes_j);
  seen.reference = std::make_shared<const Reference>(std::move(reference));
  return seen;
}

/// The model of the sensor, fitted to the mean image.
Result<PointModel> fitted_model(const SensorSnapshot& seen, const SlmGeometry& slm) {
  const ReferenceImage& image = *seen.reference->picture;
  const Image<std::uint16_t> mean = in_16_bits(image.mean_dn, image.format);
  ImageView like;
  like.width = mean.width;
  like.height = mean.height;
  like.format = image.format;
  return rendered_model(seen, slm, like, [&](PointModel& model) {
    const std::vector<double> flat(seen.modes_j.size());
    return std::pair(noise_of(view_of(mean, PixelFormat::mono16), model.rendered(flat)),
                     PixelFormat::mono16);
  });
}

FocusReport report_of(const PointModel& model, const SensorSnapshot& now, const SlmGeometry& slm) {
  FocusReport report;
  report.t_taken_ns = utc_ns();
  report.pupil_diameter_px = now.sensor.pupil_diameter_px;
  for (std::size_t k = 0; k < now.modes_j.size(); ++k) {
    const Mode mode{now.modes_j[k], model.reference_waves()[k]};
    const double error = model.reference_sigma_waves()[k];
    if (mode.j < kFirstSurfaceMode) continue;
    report.modes.push_back({{mode}, error});
    if (mode.j != kDefocus) continue;
    report.defocus_waves = mode.waves;
    report.defocus_standard_error_waves = error;
  }
  const double mm_per_wave = camera_shift_mm_per_wave(now.optics, slm, report.pupil_diameter_px);
  report.camera_shift_mm = mm_per_wave * report.defocus_waves;
  report.camera_shift_standard_error_mm =
      std::abs(mm_per_wave) * report.defocus_standard_error_waves;
  if (const auto& flatness = now.slm->flatness) {
    const auto defocus = std::ranges::find(flatness->modes, kDefocus, &Mode::j);
    report.flatness_defocus_waves = defocus == flatness->modes.end() ? 0.0 : defocus->waves;
  }
  return report;
}

}  // namespace

Result<FocusReport> measure_focus(Bench& bench, const FocusRun& run) {
  const SlmGeometry& slm = bench.geometry();
  if (auto able = can_scan(*bench.sensor()); !able) return fail(able.error());
  if (auto shown = bench.show(std::vector<Mode>{}); !shown) return fail(shown.error());
  const SensorView now = bench.sensor();
  auto modes_j = determined_modes(*now, slm);
  if (!modes_j) return fail(modes_j.error());
  const auto spots = bench.spots(run.frames);
  if (!spots) return fail(spots.error());
  const double lambda_d = lambda_d_px(now->optics, slm, now->sensor);
  if (auto still = check_average(*spots, kMaxMotion * lambda_d); !still) return fail(still.error());
  const auto found = std::ranges::count_if(spots->found, [](int times) { return times > 0; });
  if (2 * found < std::ssize(spots->found)) {
    return fail(Errc::refused, "camera.exposure_us",
                fmt::format("only {} of {} spots are found: check the exposure and the light",
                            found, spots->found.size()));
  }
  bench.report_progress(0.4);
  auto mean_dn = bench.picture(run.frames);
  if (!mean_dn) return fail(mean_dn.error());
  bench.report_progress(0.8);
  const CameraSettings camera = bench.camera().settings;
  const SensorSnapshot seen =
      seen_by(*now, std::move(*modes_j), *spots, std::move(*mean_dn), camera);
  const auto model = fitted_model(seen, slm);
  if (!model) {
    return fail(Errc::refused, "",
                "no wavefront explains the image of the spots: " + model.error().reason);
  }
  FocusReport report = report_of(*model, seen, slm);
  report.frames = run.frames;
  report.exposure_us = camera.exposure_us;
  return report;
}

}  // namespace ovws
