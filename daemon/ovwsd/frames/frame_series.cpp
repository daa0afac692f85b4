#include "daemon/ovwsd/frames/frame_series.hpp"

#include <cmath>
#include <utility>

#include "core/tracking/cell_centroid.hpp"

namespace ovws {

void FrameSeriesTaker::begin(const Wanted& wanted) {
  SeriesFrame room;
  room.spots.resize(std::size_t(wanted.spots));
  std::vector<SeriesFrame> frames(std::size_t(wanted.frames), room);
  Wanted copy = wanted;
  const std::lock_guard lock(mutex_);
  std::swap(wanted_, copy);
  std::swap(frames_, frames);
  taken_ = 0;
  ++series_;
  from_ = wanted_.cells.empty() ? From::spots : From::pixels;
}

bool FrameSeriesTaker::is_wanted(const FrameRecord& record) const {
  return taken_ < int(frames_.size()) && record.spot_count <= wanted_.spots && record.settled &&
         record.settings_known && record.hologram_id == wanted_.hologram_id &&
         same_number(record.gain_db, wanted_.gain_db) &&
         record.plan->sensor_epoch == wanted_.sensor_epoch &&
         record.plan->tracker_kind == wanted_.tracker;
}

void FrameSeriesTaker::keep(const FrameRecord& record) {
  SeriesFrame& frame = frames_[std::size_t(taken_++)];
  frame.frame_id = record.frame.frame_id;
  frame.t_arrival_ns = record.frame.t_arrival_ns;
  frame.saturated_fraction = record.saturated_fraction;
  frame.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  if (taken_ == int(frames_.size())) from_ = From::nothing;
}

void FrameSeriesTaker::add(const FrameRecord& record) {
  if (from_ != From::spots) return;
  const std::lock_guard lock(mutex_);
  if (from_ == From::spots && is_wanted(record)) keep(record);
}

bool FrameSeriesTaker::wants() {
  return from_ == From::pixels;
}

/// The pixels are looked at without the lock; what was begun meanwhile wants other ones.
void FrameSeriesTaker::take(const FrameRecord& record) {
  std::vector<Vec2> cells;
  std::uint64_t series = 0;
  {
    const std::lock_guard lock(mutex_);
    if (from_ != From::pixels || !is_wanted(record)) return;
    cells = wanted_.cells;
    series = series_;
  }
  if (cells.size() != std::size_t(record.spot_count)) return;
  const int half_px = cell_half_px(cells);
  for (Vec2& cell : cells) {
    cell = cell_centroid(record.frame.image, cell, half_px).value_or(Vec2{NAN, NAN});
  }
  const std::lock_guard lock(mutex_);
  if (from_ != From::pixels || series != series_) return;
  SeriesFrame& frame = frames_[std::size_t(taken_)];
  keep(record);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    frame.spots[i].x = float(cells[i].x);
    frame.spots[i].y = float(cells[i].y);
  }
}

int FrameSeriesTaker::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

std::vector<SeriesFrame> FrameSeriesTaker::end() {
  std::vector<SeriesFrame> frames;
  int taken = 0;
  {
    const std::lock_guard lock(mutex_);
    from_ = From::nothing;
    std::swap(frames, frames_);
    taken = std::exchange(taken_, 0);
  }
  frames.resize(std::size_t(taken));
  return frames;
}

}  // namespace ovws
