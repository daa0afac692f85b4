#include "daemon/ovwsd/frames/intensity.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

constexpr int kMaxFrames = 100'000;

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

IntensityWatch::IntensityWatch(FrameBroker& broker, std::array<Vec2, 2> places_px,
                               double radius_px) {
  const auto take = [this, places_px, radius_px](const FrameRecord& record) {
    if (!record.settings_known) return false;
    const GrabbedFrame& frame = record.frame;
    IntensityFrame seen{frame.t_device_ns, frame.t_arrival_mono_ns, record.exposure_us, {}};
    for (std::size_t k = 0; k < places_px.size(); ++k) {
      seen.mean_dn[k] = mean_around(frame.image, places_px[k], radius_px);
    }
    frames_.push_back(seen);
    return true;
  };
  request_ = broker.request(FrameBroker::Needs::pixels, kMaxFrames, take);
}

std::vector<IntensityFrame> IntensityWatch::end() {
  request_.reset();
  return std::move(frames_);
}

}  // namespace ovws
