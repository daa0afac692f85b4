#include "daemon/ovwsd/frames/frame_series.hpp"

#include <cmath>
#include <utility>

#include "core/tracking/cell_centroid.hpp"

namespace ovws {

FrameSeries::FrameSeries(int frames, int subapertures, FromPixels from)
    : subapertures_(std::size_t(subapertures)), from_(std::move(from)) {
  if (from_.tracker) scratch_ = from_.tracker->make_scratch();
  SeriesFrame room;
  room.spots.resize(subapertures_);
  frames_.assign(std::size_t(frames), room);
}

bool FrameSeries::add(const FrameRecord& record) {
  if (count_ == frames_.size() || std::size_t(record.spot_count) != subapertures_) return false;
  const std::vector<Vec2>& windows_px = from_.windows_px;
  if (!windows_px.empty() && windows_px.size() != subapertures_) return false;
  SeriesFrame& frame = frames_[count_++];
  frame.saturated_fraction = record.saturated_fraction;
  frame.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  const int half_px = windows_px.empty() ? 0 : cell_half_px(windows_px);
  for (std::size_t i = 0; i < windows_px.size(); ++i) {
    const Vec2 at =
        cell_centroid(record.frame.image, windows_px[i], half_px).value_or(Vec2{NAN, NAN});
    frame.spots[i].x = float(at.x);
    frame.spots[i].y = float(at.y);
  }
  for (std::size_t i = 0; from_.tracker && i < subapertures_; ++i) {
    SpotFix& spot = frame.spots[i];
    if (!spot.found() && i >= from_.starts_px.size()) continue;
    const Vec2 at = spot.found() ? Vec2{double(spot.x), double(spot.y)} : from_.starts_px[i];
    spot = from_.tracker->track(record.frame.image, at, scratch_);
  }
  return true;
}

std::vector<SeriesFrame> FrameSeries::take() {
  frames_.resize(count_);
  return std::exchange(frames_, {});
}

}  // namespace ovws
