#include "daemon/ovwsd/sensor/spot_average.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "proto/limits.hpp"

namespace ovws {
namespace {

void accumulate(double& mean, double& m2, double value, int count) {
  const double before = value - mean;
  mean += before / count;
  m2 += before * (value - mean);
}

double standard_error(double m2, int count) {
  return count > 1 ? std::sqrt(m2 / (double(count) * (count - 1))) : 0.0;
}

double sum_of(const Vec2& squares) {
  return squares.x + squares.y;
}

/// Allowance for noise in the squared drift, in units of the mean square that noise causes. Chosen
/// for the worst case, noise common to all spots (vibration): one false refusal in 400.
constexpr double kDriftAllowance = 6.0;
constexpr double kScatterSigmas = 3.0;  // standard deviations, for one series of frames

/// Whether the drift or the scatter (RMS over all spots, x and y) exceeds `max_motion_px` by more
/// than noise explains. Von Neumann's test: the variance of independent noise is half the mean
/// squared difference of successive positions; motion makes the variance larger.
bool has_moved(const SpotAverage& average, double max_motion_px) {
  const double limit = max_motion_px * max_motion_px;
  const double noise = average.noise_px * average.noise_px;
  const double drift_noise = average.drift_noise_px * average.drift_noise_px;
  const double allowance = kScatterSigmas / std::sqrt(std::max(1.0, double(average.frames)));
  return average.drift_px * average.drift_px > limit + kDriftAllowance * drift_noise ||
         average.scatter_px * average.scatter_px > limit + (1.0 + allowance) * noise;
}

}  // namespace

SpotAverager::SpotAverager(int frames, int subapertures)
    : frames_(frames), sums_(std::size_t(subapertures)) {}

bool SpotAverager::add(const FrameRecord& record) {
  return add(std::span(record.spots).first(std::size_t(record.spot_count)),
             full_scale_dn(record.frame.image.format));
}

bool SpotAverager::add(std::span<const SpotFix> spots, double full_dn) {
  if (spots.size() != sums_.size()) return false;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const SpotFix& spot = spots[i];
    Sums& sums = sums_[i];
    sums.saturated += spot.peak >= full_dn ? 1 : 0;
    if (spot.found()) add_position(sums, {spot.x, spot.y}, 2 * used_ < frames_);
  }
  ++used_;
  return true;
}

void SpotAverager::add_position(Sums& sums, Vec2 at, bool in_first_half) {
  if (sums.found > 0) {
    const Vec2 step = at - sums.last;
    sums.steps = sums.steps + Vec2{step.x * step.x, step.y * step.y};
  }
  sums.last = at;
  ++sums.found;
  accumulate(sums.mean.x, sums.m2.x, at.x, sums.found);
  accumulate(sums.mean.y, sums.m2.y, at.y, sums.found);
  if (!in_first_half) return;
  sums.found_first = sums.found;
  sums.mean_first = sums.mean;
}

SpotAverage SpotAverager::average() const {
  SpotAverage average;
  average.frames = used_;
  for (const Sums& sums : sums_) {
    average.found.push_back(sums.found);
    average.saturated.push_back(sums.saturated);
    average.mean_px.push_back(sums.mean);
    average.standard_error_px.push_back(
        {standard_error(sums.m2.x, sums.found), standard_error(sums.m2.y, sums.found)});
  }
  measure_motion(average);
  return average;
}

void SpotAverager::measure_motion(SpotAverage& average) const {
  double scatter = 0.0, noise = 0.0, drift = 0.0, drift_noise = 0.0;
  int spots = 0, halved = 0;
  for (const Sums& sums : sums_) {
    if (sums.found < 2) continue;
    ++spots;
    const double own_noise = 0.5 * sum_of(sums.steps) / (sums.found - 1);
    scatter += sum_of(sums.m2) / (sums.found - 1);
    noise += own_noise;
    const double first = sums.found_first, second = sums.found - sums.found_first;
    if (first < 1.0 || second < 1.0) continue;
    ++halved;
    // Mean of the second half minus mean of the first half, from the mean of all frames.
    const Vec2 moved = (double(sums.found) / second) * (sums.mean - sums.mean_first);
    drift += moved.x * moved.x + moved.y * moved.y;
    drift_noise += own_noise * (1.0 / first + 1.0 / second);
  }
  const auto rms = [](double sum, int count) {
    return count > 0 ? std::sqrt(sum / (2.0 * count)) : 0.0;
  };
  average.scatter_px = rms(scatter, spots);
  average.noise_px = rms(noise, spots);
  average.drift_px = rms(drift, halved);
  average.drift_noise_px = rms(drift_noise, halved);
}

std::vector<Vec2> found_positions(const SpotAverage& average) {
  std::vector<Vec2> positions = average.mean_px;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const int found = average.found[i];
    const bool once = found < 2 && average.frames > 1;
    if (found == 0 || once || 2 * found < average.frames) positions[i] = {NAN, NAN};
  }
  return positions;
}

std::string listed_spots(const std::vector<int>& numbers) {
  constexpr std::size_t kNamed = 8;
  const std::size_t named = std::min(numbers.size(), kNamed);
  std::string text = fmt::format("{}", fmt::join(numbers.begin(), numbers.begin() + named, ", "));
  if (numbers.size() > named) text += fmt::format(" and {} more", numbers.size() - named);
  return text;
}

std::vector<int> saturated_spots(const SpotAverage& average) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < average.saturated.size(); ++i) {
    if (average.saturated[i] > 0) numbers.push_back(int(i));
  }
  return numbers;
}

Result<void> check_average(const SpotAverage& average, double max_motion_px) {
  // Check saturation before motion, because saturation is the cause if it also loses spots.
  const double looks = double(average.frames) * double(average.saturated.size());
  const double saturated =
      std::accumulate(average.saturated.begin(), average.saturated.end(), 0.0) / looks;
  if (saturated > limits::kMaxSaturatedSpots) {
    return fail(
        Errc::refused, "camera.exposure_us",
        fmt::format("{:.0f} % of the spots are saturated (limit {:.0f} %; spots {}): lower the "
                    "exposure or the gain",
                    100.0 * saturated, 100.0 * limits::kMaxSaturatedSpots,
                    listed_spots(saturated_spots(average))));
  }
  if (!has_moved(average, max_motion_px)) return {};
  return fail(
      Errc::refused, "",
      fmt::format(
          "the spots moved by {:.2f} px RMS from the first to the second half of the reference "
          "(scatter {:.2f} px, noise {:.2f} px, limit {:.2f} px beyond noise): let the bench come "
          "to rest, then take it again",
          average.drift_px, average.scatter_px, average.noise_px, max_motion_px));
}

}  // namespace ovws
