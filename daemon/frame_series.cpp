#include "daemon/frame_series.hpp"

#include <utility>

namespace ovws {

void FrameSeriesTaker::begin(const Wanted& wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
  taken_.clear();
  taken_.reserve(std::size_t(wanted.frames));
}

void FrameSeriesTaker::add(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  if (int(taken_.size()) >= wanted_.frames || !record.settled || !record.settings_known) return;
  if (record.hologram_id != wanted_.hologram_id || record.gain_db != wanted_.gain_db) return;
  if (record.plan->sensor_epoch != wanted_.sensor_epoch) return;
  if (record.plan->tracker_kind != wanted_.tracker) return;
  SeriesFrame frame{
      record.frame.frame_id, record.frame.t_arrival_ns, record.saturated_fraction, {}};
  frame.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  taken_.push_back(std::move(frame));
}

int FrameSeriesTaker::taken() const {
  const std::lock_guard lock(mutex_);
  return int(taken_.size());
}

std::vector<SeriesFrame> FrameSeriesTaker::end() {
  const std::lock_guard lock(mutex_);
  wanted_.frames = 0;
  return std::exchange(taken_, {});
}

}  // namespace ovws
