#include "core/wavefront/diffractive_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace ovws {
namespace {

constexpr double kPeak = 60000.0;  // DN of 16 bit: rounding shifts no spot by more than 1e-5 px
constexpr int kMinSpots = 3;

std::vector<Vec2> predicted(const SensorModel& model, const SensorConfig& sensor,
                            std::span<const Mode> modes) {
  const double radius = 0.5 * sensor.pupil_diameter_px;
  std::vector<Vec2> spots = model.spots_px();
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 at = (1.0 / radius) * model.lattice().subapertures[i].centre_px;
    spots[i] = spots[i] + (model.px_per_cycle() / radius) * wavefront_gradient(modes, at);
  }
  return spots;
}

Image<std::uint16_t> rounded(const Image<float>& intensity) {
  Image<std::uint16_t> image(intensity.width, intensity.height);
  const float scale =
      float(kPeak) / *std::max_element(intensity.pixels.begin(), intensity.pixels.end());
  std::transform(intensity.pixels.begin(), intensity.pixels.end(), image.pixels.begin(),
                 [scale](float value) { return std::uint16_t(std::lround(value * scale)); });
  return image;
}

}  // namespace

Result<std::vector<SpotFix>> model_fixes(SensorModel& model, const SensorConfig& sensor,
                                         const SpotTracker& tracker, std::span<const Mode> modes) {
  const auto intensity = model.intensity(modes);
  if (!intensity) return fail(intensity.error());
  const Image<std::uint16_t> image = rounded(*intensity);
  const ImageView view = view_of(image, PixelFormat::mono16);
  TrackScratch scratch = tracker.make_scratch();
  std::vector<SpotFix> fixes;
  for (const Vec2 start : predicted(model, sensor, modes)) {
    fixes.push_back(tracker.track(view, start, scratch));
  }
  return fixes;
}

Result<DiffractiveMatrix> diffractive_matrix(SensorModel& model, const SensorConfig& sensor,
                                             const SpotTracker& tracker,
                                             std::span<const int> modes_j, double step_waves,
                                             const std::atomic<bool>* stop) {
  const auto flat = model_fixes(model, sensor, tracker, {});
  if (!flat) return fail(flat.error());
  DiffractiveMatrix matrix;
  matrix.slopes = Eigen::MatrixXd::Zero(2 * Eigen::Index(flat->size()), modes_j.size());
  for (const SpotFix& fix : *flat) matrix.reference_px.push_back({double(fix.x), double(fix.y)});
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (stop != nullptr && *stop) return fail(Errc::refused, "tracking", "cancelled");
    const Mode up{modes_j[k], step_waves}, down{modes_j[k], -step_waves};
    const auto above = model_fixes(model, sensor, tracker, {&up, 1});
    if (!above) return fail(above.error());
    const auto below = model_fixes(model, sensor, tracker, {&down, 1});
    if (!below) return fail(below.error());
    for (std::size_t i = 0; i < flat->size(); ++i) {
      const SpotFix &a = (*above)[i], &b = (*below)[i];
      if (!a.found() || !b.found()) matrix.reference_px[i] = {NAN, NAN};
      matrix.slopes(2 * i, k) = double(a.x - b.x) / (2.0 * step_waves);
      matrix.slopes(2 * i + 1, k) = double(a.y - b.y) / (2.0 * step_waves);
    }
  }
  int tracked = 0;
  for (std::size_t i = 0; i < flat->size(); ++i) {
    const bool always_found = std::isfinite(matrix.reference_px[i].x);
    tracked += always_found ? 1 : 0;
    if (!always_found) matrix.slopes.middleRows(2 * i, 2).setZero();
  }
  if (tracked >= kMinSpots) return matrix;
  return fail(
      Errc::refused, "tracking",
      "the tracker finds only " + std::to_string(tracked) + " of " + std::to_string(flat->size()) +
          " spots in the image that is computed for the diffractive operator: set camera.roi so "
          "that it contains the spots, choose another tracker, or choose operator slopes");
}

}  // namespace ovws
