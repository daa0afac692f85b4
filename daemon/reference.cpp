#include "daemon/reference.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr double kMostSaturated = 0.1;  // of all spots in all frames

void accumulate(double& mean, double& m2, double value, int count) {
  const double before = value - mean;
  mean += before / count;
  m2 += before * (value - mean);
}

double standard_error(double m2, int count) {
  return count > 1 ? std::sqrt(m2 / (double(count) * (count - 1))) : 0.0;
}

}  // namespace

ReferenceKey reference_key(const SensorConfig& sensor, const TrackingSettings& tracking,
                           const Roi& roi) {
  ReferenceKey key{sensor, tracking, roi};
  if (tracking.tracker != TrackerKind::matched) key.tracking.templates = TemplateKind::model;
  key.tracking.mode_operator = OperatorKind::slopes;
  return key;
}

void ReferenceCollector::begin(int frames, std::uint64_t sensor_epoch, std::uint64_t hologram_id,
                               int subapertures, Done done) {
  const std::lock_guard lock(mutex_);
  wanted_ = frames;
  used_ = 0;
  t_last_used_ns_ = monotonic_ns();
  sensor_epoch_ = sensor_epoch;
  hologram_id_ = hologram_id;
  sums_.assign(std::size_t(subapertures), Sums{});
  done_ = std::move(done);
}

void ReferenceCollector::cancel() {
  const std::lock_guard lock(mutex_);
  wanted_ = 0;
  done_ = nullptr;
}

void ReferenceCollector::add(const FrameRecord& record) {
  Done done;
  Average result;
  {
    const std::lock_guard lock(mutex_);
    if (wanted_ == 0 || !record.settled || record.plan->sensor_epoch != sensor_epoch_) return;
    if (record.hologram_id != hologram_id_) return;
    if (std::size_t(record.spot_count) != sums_.size()) return;
    const double full = full_scale_dn(record.frame.image.format);
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const SpotFix& spot = record.spots[i];
      Sums& sums = sums_[i];
      sums.saturated += spot.peak >= full ? 1 : 0;
      if (!spot.found()) continue;
      ++sums.found;
      accumulate(sums.mean.x, sums.m2.x, spot.x, sums.found);
      accumulate(sums.mean.y, sums.m2.y, spot.y, sums.found);
    }
    t_last_used_ns_ = monotonic_ns();
    if (++used_ < wanted_) return;
    wanted_ = 0;
    done = std::exchange(done_, nullptr);
    result = average();
  }
  done(std::move(result));
}

double ReferenceCollector::progress() const {
  const std::lock_guard lock(mutex_);
  return wanted_ > 0 ? double(used_) / wanted_ : 0.0;
}

double ReferenceCollector::idle_s() const {
  const std::lock_guard lock(mutex_);
  return wanted_ > 0 ? 1e-9 * double(monotonic_ns() - t_last_used_ns_) : 0.0;
}

ReferenceCollector::Average ReferenceCollector::average() const {
  Average average;
  average.frames = used_;
  for (const Sums& sums : sums_) {
    average.found.push_back(sums.found);
    average.saturated.push_back(sums.saturated);
    average.mean_px.push_back(sums.mean);
    average.standard_error_px.push_back(
        {standard_error(sums.m2.x, sums.found), standard_error(sums.m2.y, sums.found)});
  }
  return average;
}

std::string listed_spots(const std::vector<int>& numbers) {
  constexpr std::size_t kNamed = 8;
  const std::size_t named = std::min(numbers.size(), kNamed);
  std::string text = fmt::format("{}", fmt::join(numbers.begin(), numbers.begin() + named, ", "));
  if (numbers.size() > named) text += fmt::format(" and {} more", numbers.size() - named);
  return text;
}

std::vector<int> saturated_spots(const ReferenceCollector::Average& average) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < average.saturated.size(); ++i) {
    if (average.saturated[i] > 0) numbers.push_back(int(i));
  }
  return numbers;
}

Result<void> check_average(const ReferenceCollector::Average& average) {
  // Saturation first, for it loses spots as well.
  const double looks = double(average.frames) * double(average.saturated.size());
  const double saturated =
      std::accumulate(average.saturated.begin(), average.saturated.end(), 0.0) / looks;
  if (saturated > kMostSaturated) {
    return fail(
        Errc::refused, "camera.exposure_us",
        fmt::format("{:.0f} % of the spots are saturated, and more than {:.0f} % displace a "
                    "reference (spots {}): lower the exposure or the gain",
                    100.0 * saturated, 100.0 * kMostSaturated,
                    listed_spots(saturated_spots(average))));
  }
  std::vector<int> too_rare;
  for (std::size_t i = 0; i < average.found.size(); ++i) {
    if (2 * average.found[i] < average.frames) too_rare.push_back(int(i));
  }
  if (too_rare.empty()) return {};
  return fail(
      Errc::refused, "",
      fmt::format("spots {} were found in fewer than half of the frames: check the image, the "
                  "exposure and the region of interest, or use fewer subapertures",
                  listed_spots(too_rare)));
}

}  // namespace ovws
