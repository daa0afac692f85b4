#include "daemon/ovwsd/frames/light_watcher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

double mean_around(const ImageView& image, Vec2 place, double radius_px) {
  const int left = std::max(0, int(std::ceil(place.x - radius_px)));
  const int right = std::min(image.width - 1, int(std::floor(place.x + radius_px)));
  const int top = std::max(0, int(std::ceil(place.y - radius_px)));
  const int bottom = std::min(image.height - 1, int(std::floor(place.y + radius_px)));
  double sum = 0.0;
  const int columns = std::max(0, right - left + 1), rows = std::max(0, bottom - top + 1);
  visit_rows(image, left, top, columns, rows, [&](int, int, const auto* pixels, int count) {
    for (int i = 0; i < count; ++i) sum += double(pixels[i]);
  });
  const int count = columns * rows;
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

void LightWatcher::begin(std::array<Vec2, 2> places_px, double radius_px) {
  const std::lock_guard lock(mutex_);
  watching_ = true;
  places_px_ = places_px;
  radius_px_ = radius_px;
  seen_.clear();
}

std::vector<LightWatcher::Seen> LightWatcher::end() {
  const std::lock_guard lock(mutex_);
  watching_ = false;
  return std::exchange(seen_, {});
}

std::size_t LightWatcher::count() {
  const std::lock_guard lock(mutex_);
  return seen_.size();
}

bool LightWatcher::wants() {
  const std::lock_guard lock(mutex_);
  return watching_ && seen_.size() < kMost;
}

void LightWatcher::take(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  if (!watching_ || !record.settings_known) return;
  const GrabbedFrame& frame = record.frame;
  Seen seen{frame.t_device_ns, frame.t_arrival_mono_ns, record.exposure_us, {}};
  for (std::size_t k = 0; k < places_px_.size(); ++k) {
    seen.light_dn[k] = mean_around(frame.image, places_px_[k], radius_px_);
  }
  seen_.push_back(seen);
}

}  // namespace ovws
