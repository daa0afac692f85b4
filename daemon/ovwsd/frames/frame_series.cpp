#include "daemon/ovwsd/frames/frame_series.hpp"

#include <cmath>
#include <utility>

#include "core/tracking/cell_centroid.hpp"

namespace ovws {

FrameSeries::FrameSeries(int frames, int subapertures, std::vector<Vec2> windows_px)
    : subapertures_(std::size_t(subapertures)), windows_px_(std::move(windows_px)) {
  SeriesFrame room;
  room.spots.resize(subapertures_);
  frames_.assign(std::size_t(frames), room);
}

bool FrameSeries::add(const FrameRecord& record) {
  if (count_ == frames_.size() || std::size_t(record.spot_count) != subapertures_) return false;
  if (needs_pixels() && windows_px_.size() != subapertures_) return false;
  SeriesFrame& frame = frames_[count_++];
  frame.frame_id = record.frame.frame_id;
  frame.t_arrival_ns = record.frame.t_arrival_ns;
  frame.saturated_fraction = record.saturated_fraction;
  frame.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  const int half_px = needs_pixels() ? cell_half_px(windows_px_) : 0;
  for (std::size_t i = 0; i < windows_px_.size(); ++i) {
    const Vec2 at =
        cell_centroid(record.frame.image, windows_px_[i], half_px).value_or(Vec2{NAN, NAN});
    frame.spots[i].x = float(at.x);
    frame.spots[i].y = float(at.y);
  }
  return true;
}

std::vector<SeriesFrame> FrameSeries::take() {
  frames_.resize(count_);
  return std::exchange(frames_, {});
}

}  // namespace ovws
