#include "daemon/frame_series.hpp"

#include <cmath>
#include <utility>

#include "core/tracking/cell_centroid.hpp"

namespace ovws {
namespace {

SeriesFrame frame_of(const FrameRecord& record) {
  SeriesFrame frame{
      record.frame.frame_id, record.frame.t_arrival_ns, record.saturated_fraction, {}};
  frame.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  return frame;
}

}  // namespace

void FrameSeriesTaker::begin(const Wanted& wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
  taken_.clear();
  taken_.reserve(std::size_t(wanted.frames));
}

bool FrameSeriesTaker::is_wanted(const FrameRecord& record) const {
  return int(taken_.size()) < wanted_.frames && record.settled && record.settings_known &&
         record.hologram_id == wanted_.hologram_id && record.gain_db == wanted_.gain_db &&
         record.plan->sensor_epoch == wanted_.sensor_epoch &&
         record.plan->tracker_kind == wanted_.tracker;
}

void FrameSeriesTaker::add(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  if (wanted_.cells.empty() && is_wanted(record)) taken_.push_back(frame_of(record));
}

bool FrameSeriesTaker::wants() {
  const std::lock_guard lock(mutex_);
  return !wanted_.cells.empty() && int(taken_.size()) < wanted_.frames;
}

void FrameSeriesTaker::take(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  if (wanted_.cells.size() != std::size_t(record.spot_count) || !is_wanted(record)) return;
  SeriesFrame frame = frame_of(record);
  const int half_px = cell_half_px(wanted_.cells);
  for (std::size_t i = 0; i < frame.spots.size(); ++i) {
    const auto at = cell_centroid(record.frame.image, wanted_.cells[i], half_px);
    frame.spots[i].x = at ? float(at->x) : NAN;
    frame.spots[i].y = at ? float(at->y) : NAN;
  }
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
