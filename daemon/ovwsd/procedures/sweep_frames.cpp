#include "daemon/ovwsd/procedures/sweep_frames.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/wavefront/residual_variance.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {
namespace {

constexpr double kStandardErrors =
    4.0;  // rarely exceeded by chance, even by the worst of 100 spots
constexpr const char* kHowToContinue =
    "the cells measured so far are kept: restore the alignment and call again, or start a new run "
    "with \"anew\": true";

SpotAverage average_of(const std::vector<SeriesFrame>& frames) {
  const std::size_t spots = frames.empty() ? 0 : frames.front().spots.size();
  SpotAverager averager(int(frames.size()), int(spots));
  for (const SeriesFrame& frame : frames) {
    averager.add(frame.spots, std::numeric_limits<double>::infinity());
  }
  return averager.average();
}

double median(std::vector<float> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return double(*middle);
}

}  // namespace

std::vector<Vec2> mean_positions(const std::vector<SeriesFrame>& frames) {
  return found_positions(average_of(frames));
}

SpotLevels levels_of(const std::vector<SeriesFrame>& frames) {
  std::vector<float> levels, noises;
  SpotLevels all{NAN, NAN, NAN};
  for (const SeriesFrame& frame : frames) {
    for (const SpotFix& spot : frame.spots) {
      all.peak_dn = std::fmax(all.peak_dn, double(spot.peak));
      if (!spot.found()) continue;
      levels.push_back(spot.level);
      if (spot.noise > 0.0F) noises.push_back(spot.noise);
    }
  }
  all.level_dn = median(std::move(levels));
  all.noise_dn = median(std::move(noises));
  return all;
}

std::vector<CellMeasured::Frame> judge_frames(const std::vector<SeriesFrame>& frames,
                                              const Reconstructor& reconstructor,
                                              const std::vector<Mode>& introduced) {
  Reconstructor::Scratch scratch = reconstructor.make_scratch();
  std::vector<float> waves(reconstructor.modes_j().size());
  std::vector<CellMeasured::Frame> judged;
  for (const SeriesFrame& frame : frames) {
    CellMeasured::Frame one;
    one.saturated_fraction = double(frame.saturated_fraction);
    one.tracked = int(std::count_if(frame.spots.begin(), frame.spots.end(),
                                    [](const SpotFix& spot) { return spot.found(); }));
    one.variance_rad2 = NAN;
    if (reconstructor.solve(frame.spots, scratch, waves).determined) {
      one.coefficients.assign(waves.begin(), waves.end());
      one.variance_rad2 = residual_variance_rad2<float>(reconstructor.modes_j(), waves, introduced);
    }
    judged.push_back(std::move(one));
  }
  return judged;
}

SpotMotion spot_motion(const std::vector<Vec2>& before_px, int frames_before,
                       const std::vector<SeriesFrame>& frames) {
  SpotMotion motion;
  int compared = 0;
  const SpotAverage now = average_of(frames);
  const std::vector<Vec2> now_px = found_positions(now);
  for (std::size_t i = 0; i < before_px.size(); ++i) {
    if (std::isnan(before_px[i].x)) continue;
    if (i >= now_px.size() || std::isnan(now_px[i].x)) {
      ++motion.lost;
      continue;
    }
    const Vec2 moved = now_px[i] - before_px[i];
    const double length_px = std::hypot(moved.x, moved.y);
    if (length_px > motion.largest_px) {
      motion.largest_px = length_px;
      motion.largest_at = int(i);
    }
    motion.mean_px = motion.mean_px + moved;
    ++compared;
    // Standard error of the motion per axis, if single frames of the earlier mean scatter as much
    // as `frames`.
    const Vec2 error = now.standard_error_px[i];
    const double more = 1.0 + double(now.found[i]) / std::max(1, frames_before);
    motion.standard_error_px =
        std::fmax(motion.standard_error_px, std::sqrt(0.5 * more) * std::hypot(error.x, error.y));
  }
  if (compared > 0) motion.mean_px = (1.0 / compared) * motion.mean_px;
  return motion;
}

Result<void> check_unmoved(const SpotMotion& motion, double limit_px, const std::string& arm) {
  if (motion.lost > 0) {
    return fail(
        Errc::refused, "anew",
        fmt::format("{} spots of the run's reference ({}) are no longer found: the bench moved, "
                    "or the intensity fell; {}",
                    motion.lost, arm, kHowToContinue));
  }
  const double uncertainty_px = kStandardErrors * motion.standard_error_px;
  if (motion.largest_px > std::fmax(limit_px, uncertainty_px)) {
    return fail(Errc::refused, "anew",
                fmt::format("the bench moved since the run's reference ({}) was taken: the spot of "
                            "subaperture {} by {:.2f} px, all spots by ({:+.2f}, {:+.2f}) px on "
                            "average, and {:.2f} px (lambda/(20 d)) are allowed; {}",
                            arm, motion.largest_at, motion.largest_px, motion.mean_px.x,
                            motion.mean_px.y, limit_px, kHowToContinue));
  }
  if (uncertainty_px <= limit_px) return {};
  return fail(
      Errc::refused, "reference_frames",
      fmt::format(
          "the spots are too noisy to determine whether the bench moved since the run's "
          "reference ({}) was taken: four standard errors of a spot's motion are {:.2f} px, "
          "more than the limit of {:.2f} px (lambda/(20 d)); start a new run with more "
          "reference_frames or a higher intensity. The cells measured so far are kept",
          arm, uncertainty_px, limit_px));
}

}  // namespace ovws
