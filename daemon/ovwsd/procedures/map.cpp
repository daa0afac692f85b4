#include "daemon/ovwsd/procedures/measurements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/decompositions.hpp"
#include "core/optics/flatness.hpp"
#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/phase_retrieval.hpp"
#include "daemon/ovwsd/procedures/probes.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr double kImagesShare = 0.6;       // of the progress
constexpr double kMaxMisfit = 0.2;         // relative RMS: a retrieval that failed leaves more
constexpr double kMaxSaturated = 0.001;    // share of an image's pixels
constexpr double kMinSignificance = 10.0;  // brightest pixels above the background's noise
constexpr double kBright = 0.999;          // quantile that counts as brightest
constexpr double kMaxDifference = 0.02;    // waves RMS, of maps from both images of each pattern
constexpr double kMaxImageMotion = 0.2;    // lambda/D, which adds 0.005 waves of error
constexpr int kLastMapMode = 65;           // of radial order 10, as in flatness.run

/// What all images of the job have in common.
struct Setting {
  Bench& bench;
  const SensorSnapshot& now;
  const SlmGeometry& slm;
  const MapRun& run;
  PhaseRetrieval retrieval;
  int left = 0, top = 0;  ///< the window in the image
};

/// Sends the light outside the pupil, or all of it, out of the camera's sight.
std::shared_ptr<Picture> pattern_picture(const Setting& s, bool dark, std::vector<Mode> modes) {
  auto picture = std::make_shared<Picture>();
  picture->modes = std::move(modes);
  picture->waves = Image<float>(s.slm.width_px, s.slm.height_px);
  const Vec2 base = base_grating_cpp(s.now.sensor, s.slm);
  const Vec2 centre{0.5 * (s.slm.width_px - 1), 0.5 * (s.slm.height_px - 1)};
  for (int y = 0; y < s.slm.height_px; ++y) {
    for (int x = 0; x < s.slm.width_px; ++x) {
      const Vec2 at = Vec2{double(x), double(y)} - centre;
      const bool lit = !dark && norm(at) <= 0.5 * s.now.sensor.pupil_diameter_px;
      picture->waves.at(x, y) =
          lit ? float(base.x * at.x + base.y * at.y) : 0.5F * float((x + y) % 2);
    }
  }
  return picture;
}

/// The window of the mean image while the picture is shown, DN.
Result<Image<float>> look(const Setting& s, bool dark, std::vector<Mode> modes = {}) {
  const std::shared_ptr<const Picture> picture = pattern_picture(s, dark, std::move(modes));
  const Painter paint = [picture](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
    renderer.render_picture(*picture, grey);
  };
  if (auto shown = s.bench.show(paint); !shown) return fail(shown.error());
  auto all = s.bench.picture(s.run.frames);
  if (!all) return all;
  const int side = s.retrieval.window_px();
  if (s.left + side > all->width || s.top + side > all->height) {
    return fail(Errc::refused, "camera",
                "the camera's region changed during the job; start it again");
  }
  Image<float> window(side, side);
  for (int y = 0; y < side; ++y) {
    std::copy_n(all->row(s.top + y) + s.left, side, window.row(y));
  }
  return window;
}

/// Of the pixels that are not saturated, which are NaN.
double noise_of(const Image<float>& dark) {
  double sum = 0.0;
  int count = 0;
  for (const float dn : dark.pixels) {
    if (std::isnan(dn)) continue;
    sum += double(dn);
    ++count;
  }
  Image<float> about = dark;
  for (float& dn : about.pixels) dn -= float(sum / count);
  return rms_of(about);
}

Result<void> check_image(const Image<float>& image, double noise_dn) {
  std::vector<float> seen;
  std::ranges::copy_if(image.pixels, std::back_inserter(seen),
                       [](float dn) { return !std::isnan(dn); });
  const double saturated = 1.0 - double(seen.size()) / double(image.pixels.size());
  if (saturated > kMaxSaturated) return fail(saturated_spot());
  const auto bright = seen.begin() + std::ptrdiff_t(kBright * double(seen.size() - 1));
  std::ranges::nth_element(seen, bright);
  if (double(*bright) > kMinSignificance * noise_dn) return {};
  return fail(Errc::refused, "camera.exposure_us",
              fmt::format("the brightest pixels of a pattern have {:.1f} DN, at a noise of {:.1f}: "
                          "increase the exposure, or check the laser and its beam",
                          *bright, noise_dn));
}

using Images = std::vector<DiverseImage>;

/// Centroid of the squared image, which hardly sees the background, px.
Vec2 place_of(const Image<float>& image) {
  Vec2 sum;
  double weight = 0.0;
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    const double dn = double(image.pixels[k]);
    if (std::isnan(dn)) continue;
    const auto column = k % std::size_t(image.width), row = k / std::size_t(image.width);
    sum = sum + dn * dn * Vec2{double(column), double(row)};
    weight += dn * dn;
  }
  return (1.0 / weight) * sum;
}

/// Whether both images of each pattern are at the same place.
Result<void> check_still(const std::array<Images, 2>& taken, double lambda_d_px) {
  double moved_px = 0.0;
  for (std::size_t k = 0; k < taken[0].size(); ++k) {
    const Vec2 first = place_of(taken[0][k].intensity), second = place_of(taken[1][k].intensity);
    moved_px = std::max(moved_px, norm(second - first));
  }
  if (moved_px <= kMaxImageMotion * lambda_d_px) return {};
  return fail(Errc::refused, "",
              fmt::format("the image moved by {:.1f} px during the job, more than {:.1f}: check "
                          "that camera and optics are fixed and the air is calm, or average more "
                          "frames, and start it again",
                          moved_px, kMaxImageMotion * lambda_d_px));
}

/// Images of all patterns, twice.
Result<std::array<Images, 2>> take_images(const Setting& s) {
  const auto patterns = diversity_patterns(s.run.patterns, s.run.cells);
  auto dark = look(s, true);
  if (!dark) return fail(dark.error());
  const double noise_dn = noise_of(*dark);
  std::array<Images, 2> taken;
  int done = 0;
  for (Images& images : taken) {
    for (const auto& modes : patterns) {
      auto image = look(s, false, modes);
      if (!image) return fail(image.error());
      for (std::size_t k = 0; k < image->pixels.size(); ++k) image->pixels[k] -= dark->pixels[k];
      if (auto good = check_image(*image, noise_dn); !good) return fail(good.error());
      images.push_back({modes, std::move(*image)});
      s.bench.report_progress(kImagesShare * ++done / double(2 * patterns.size()));
    }
  }
  const double lambda_d_px = double(s.retrieval.window_px()) / s.run.cells;
  if (auto still = check_still(taken, lambda_d_px); !still) return fail(still.error());
  return taken;
}

Result<Setting> setting_of(Bench& bench, const SensorSnapshot& now, const MapRun& run) {
  const SlmGeometry& slm = bench.geometry();
  if (auto able = can_scan(now); !able) return fail(able.error());
  if (now.slm->flatness && now.slm->flatness->pupil_diameter_px != now.sensor.pupil_diameter_px) {
    return fail(Errc::refused, "sensor.pupil_diameter_px",
                "the active flatness was measured over another pupil: call flatness.clear first");
  }
  const CameraSettings camera = bench.camera().settings;
  if (lit_pixels(camera.pixel_format, now.optics.wavelength_nm).plane.step > 1) {
    return fail(
        Errc::refused, "camera.pixel_format",
        "a map needs every pixel, but a colour camera's filters pass the laser in only some "
        "of them: use a monochrome camera, or flatness.run");
  }
  auto retrieval =
      PhaseRetrieval::make(px_per_cycle(now.optics, slm), now.sensor.pupil_diameter_px, run.cells);
  if (!retrieval) return fail(retrieval.error());
  const Roi roi = camera.roi;
  const int side = retrieval->window_px();
  const Vec2 base = base_spot_px(now.optics, roi.width, roi.height);
  const int left = int(std::lround(base.x - 0.5 * (side - 1)));
  const int top = int(std::lround(base.y - 0.5 * (side - 1)));
  if (left < 0 || top < 0 || left + side > roi.width || top + side > roi.height) {
    return fail(Errc::refused, "camera.roi",
                fmt::format("a map of {} cells requires {} x {} pixels about the base spot at "
                            "{:.0f}, {:.0f}: enlarge or move the region, or use fewer cells",
                            run.cells, side, side, base.x, base.y));
  }
  return Setting{bench, now, slm, run, std::move(*retrieval), left, top};
}

/// Least-squares fit of the modes j = 1 .. kLastMapMode to a map.
Eigen::VectorXd modes_of(const Image<float>& map) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(kLastMapMode + 1, kLastMapMode + 1);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(kLastMapMode + 1), here(kLastMapMode + 1);
  for (int k = 0; k < map.width * map.height; ++k) {
    if (std::isnan(map.pixels[std::size_t(k)])) continue;
    const Vec2 at = cell_centre(map.width, k);
    for (int j = 0; j <= kLastMapMode; ++j) here[j] = zernike(j, at);
    sums.selfadjointView<Eigen::Lower>().rankUpdate(here);
    values += double(map.pixels[std::size_t(k)]) * here;
  }
  return solve_symmetric(sums, values);
}

/// Modes of the map, with the rest that they leave.
void split(const BenchMap& map, MeasuredFlatness& flatness) {
  const Eigen::VectorXd waves = modes_of(map.error), doubt = modes_of(map.half_difference);
  flatness.fine = map.error;
  for (int j = kFirstSurfaceMode; j <= kLastMapMode; ++j) {
    flatness.modes.push_back({j, waves[j]});
    flatness.standard_error_waves.push_back(std::abs(doubt[j]));
  }
  for (int k = 0; k < map.error.width * map.error.height; ++k) {
    for (const Mode& mode : flatness.modes) {
      flatness.fine.pixels[std::size_t(k)] -=
          float(mode.waves * zernike(mode.j, cell_centre(map.error.width, k)));
    }
  }
}

/// The error that the flatness in use removes, on the cells of `like`.
Image<float> removed(const MeasuredFlatness* flatness, const Image<float>& like) {
  Image<float> map(like.width, like.height);
  for (int k = 0; k < like.width * like.height; ++k) {
    float& waves = map.pixels[std::size_t(k)];
    const Vec2 at = cell_centre(like.width, k);
    if (std::isnan(like.pixels[std::size_t(k)])) waves = like.pixels[std::size_t(k)];
    if (flatness == nullptr) continue;
    for (const Mode& mode : flatness->modes) waves += float(mode.waves * zernike(mode.j, at));
    if (!flatness->fine.pixels.empty()) waves += value_at(flatness->fine, at);
  }
  remove_tilts(map);
  return map;
}

/// Whether the images are explained, by a phase that does not jump.
Result<void> check_smooth(const PhaseRetrieval::Found& found) {
  if (found.misfit > kMaxMisfit) {
    return fail(Errc::refused, "",
                fmt::format("no wavefront explains the images (misfit {:.2f}): check that nothing "
                            "moves, and run registration.run and lut.run",
                            found.misfit));
  }
  if (!found.singularity) return {};
  return fail(Errc::refused, "",
              fmt::format("the phase jumps, as at a branch point (phase singularity) near x "
                          "{:+.2f}, y {:+.2f} pupil radii: check that the light has no vortex "
                          "there, that the images are bright, and that nothing moves; run "
                          "registration.run, or show more patterns",
                          found.singularity->x, found.singularity->y));
}

Result<BenchMap> retrieve(const Setting& s, const std::array<Images, 2>& images) {
  std::array<PhaseRetrieval::Found, 2> found;
  const auto stop = [&] { return s.bench.stopped(); };
  for (std::size_t k = 0; k < 2; ++k) {
    auto one = s.retrieval.retrieve(images[k], k == 0, stop);
    if (!one) return fail(one.error());
    if (auto smooth = check_smooth(*one); !smooth) return fail(smooth.error());
    found[k] = std::move(*one);
    s.bench.report_progress(kImagesShare + 0.5 * double(k + 1) * (1.0 - kImagesShare));
  }
  BenchMap map;
  map.error = map.half_difference = found[0].waves;
  for (std::size_t k = 0; k < map.error.pixels.size(); ++k) {
    const float a = found[0].waves.pixels[k], b = found[1].waves.pixels[k];
    map.error.pixels[k] = 0.5F * (a + b);
    map.half_difference.pixels[k] = 0.5F * (a - b);
  }
  map.misfit = std::max(found[0].misfit, found[1].misfit);
  map.resolution_px = s.now.sensor.pupil_diameter_px / s.run.cells *
                      common_resolution(found[0].waves, found[1].waves);
  if (const double doubt = rms_of(map.half_difference); doubt > kMaxDifference) {
    return fail(Errc::refused, "",
                fmt::format("both images of each pattern disagree by {:.3f} waves RMS: average "
                            "more frames, and check that nothing moves",
                            2.0 * doubt));
  }
  return map;
}

Result<BenchMap> map_at_this_exposure(Bench& bench, const MapRun& run) {
  const SensorView view = bench.sensor();
  const auto setting = setting_of(bench, *view, run);
  if (!setting) return fail(setting.error());
  const auto images = take_images(*setting);
  if (!images) return fail(images.error());
  const std::int64_t begin_ns = monotonic_ns();
  auto map = retrieve(*setting, *images);
  if (!map) return fail(map.error());
  MapReport& report = map->report;
  report.seconds = 1e-9 * double(monotonic_ns() - begin_ns);
  const auto& before = view->slm->flatness;
  const Image<float> in_use = removed(before.get(), map->error);
  report.difference_rms_waves = rms_of(map->error);
  for (std::size_t k = 0; k < in_use.pixels.size(); ++k) {
    map->error.pixels[k] += in_use.pixels[k];
  }
  report.t_taken_ns = utc_ns();
  report.patterns = run.patterns;
  report.frames = run.frames;
  report.exposure_us = bench.camera().settings.exposure_us;
  report.pupil_diameter_px = view->sensor.pupil_diameter_px;
  report.cell_px = report.pupil_diameter_px / run.cells;
  report.resolution_px = map->resolution_px;
  report.misfit = map->misfit;
  report.standard_error_waves = rms_of(map->half_difference);
  report.rms_waves = rms_of(map->error);
  report.flatness_rms_waves = rms_of(in_use);
  report.map = picture_of(map->error);
  report.flatness = picture_of(in_use);
  return map;
}

}  // namespace

Result<BenchMap> measure_map(Bench& bench, const MapRun& run) {
  return unsaturated(bench, [&] { return map_at_this_exposure(bench, run); });
}

MeasuredFlatness flatness_of(const BenchMap& map) {
  MeasuredFlatness flatness;
  flatness.t_taken_ns = map.report.t_taken_ns;
  flatness.frames = map.report.frames;
  flatness.iterations = 1;
  flatness.pupil_diameter_px = map.report.pupil_diameter_px;
  flatness.residual_rms_waves = map.report.standard_error_waves;
  split(map, flatness);
  return flatness;
}

}  // namespace ovws
