#include "daemon/reference.hpp"

#include <utility>

#include "core/port/clock.hpp"

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
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const SpotFix& spot = record.spots[i];
      if (!spot.found()) continue;
      Sums& sums = sums_[i];
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
    average.mean_px.push_back(sums.mean);
    average.standard_error_px.push_back(
        {standard_error(sums.m2.x, sums.found), standard_error(sums.m2.y, sums.found)});
  }
  return average;
}

}  // namespace ovws
