// Frames of any format, size and content, their numbers anywhere: all builds of the loops give the
// same pixels, whatever reads them stays inside the frame, and a tracker gives a place or none.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "core/base/pixels.hpp"
#include "core/base/unpack.hpp"
#include "core/pipeline/msb_alignment.hpp"
#include "core/tracking/acquisition.hpp"
#include "core/tracking/patch.hpp"

namespace {

using namespace ovws;

void demand(bool condition) {
  if (!condition) std::abort();
}

/// What is not given is 0.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int next() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  int below(int n) { return (next() << 8 | next()) % std::max(n, 1); }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

/// Exactly as long as its pixels need, so that a byte read beyond them is seen.
struct Frame {
  explicit Frame(Bytes& from) {
    const auto formats = all_pixel_formats();
    view.format = formats[std::size_t(from.below(int(formats.size())))].format;
    const int group = pixels_per_group(view.format);
    view.width = (16 + from.below(200)) / group * group;
    view.height = 16 + from.below(100);
    const std::size_t line = row_bytes(view.format, view.width);
    view.stride_bytes = std::ptrdiff_t(line) + from.below(4);
    bytes.resize(std::size_t(view.stride_bytes) * std::size_t(view.height - 1) + line);
    int value = from.next();
    for (std::byte& byte : bytes) {
      if (from.next() % 16 == 0) value = from.next();
      byte = std::byte(value = (value * 5 + 1) & 0xFF);
    }
    view.data = bytes.data();
  }
  std::vector<std::byte> bytes;
  ImageView view;
};

void unpack_alike(const ImageView& image, Bytes& from) {
  const int y = from.below(image.height), x = from.below(image.width);
  const int count = from.below(image.width - x + 1);
  const ColourPlane& l = image.plane;
  const PackedRow row{image.row<std::byte>(l.y + y * l.step),
                      std::ptrdiff_t(row_bytes(image.format, l.x + (image.width - 1) * l.step + 1)),
                      image.left_justified_bits};
  std::vector<std::uint16_t> first(std::size_t(count) + 1), other(first);
  const UnpackRow unpack = unpack_row(traits_of(image.format).layout, l.step);
  unpack(row, l.x + x * l.step, count, first.data());
  // One pixel at a time is unpacked without SIMD.
  for (int i = 0; i < count; ++i) unpack(row, l.x + (x + i) * l.step, 1, other.data() + i);
  demand(first == other);
}

/// Kept: to make templates takes longer than all the rest.
const SpotTracker& tracker_of(TrackerKind kind, const SpotModel& spots) {
  struct Kept {
    TrackerKind kind;
    LitPixels lit;
    std::unique_ptr<const SpotTracker> tracker;
  };
  static std::vector<Kept> all;
  for (const Kept& one : all) {
    if (one.kind == kind && one.lit == spots.lit) return *one.tracker;
  }
  auto made = make_tracker({kind, 0.3}, spots);
  demand(made.has_value());
  all.push_back({kind, spots.lit, std::move(*made)});
  return *all.back().tracker;
}

void track(const ImageView& frame, const SpotModel& spots, Bytes& from) {
  const SpotTracker& tracker = tracker_of(TrackerKind::lg, spots);
  TrackScratch scratch = tracker.make_scratch();
  const Vec2 start{from.below(frame.width + 20) - 10.0, from.below(frame.height + 20) - 10.0};
  const SpotFix fix = tracker.track(frame, start, scratch);
  demand(!fix.found() || (std::isfinite(fix.x) && std::isfinite(fix.y)));
  Acquisition acquisition(spots, {{20.0, 20.0}, {60.0, 20.0}, {40.0, 50.0}}, frame.width,
                          frame.height);
  std::vector<SpotFix> fixes(3);
  acquisition.acquire(frame, tracker, scratch, fixes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes from(data, size);
  Frame frame(from);
  MsbAlignmentDetector detector;
  frame.view.left_justified_bits = detector.shift_bits(frame.view);
  const LitPixels lit = lit_pixels(frame.view.format, 400.0 + from.below(400));
  unpack_alike(frame.view, from);
  const ImageView image = on_plane(frame.view, lit.plane);
  unpack_alike(image, from);
  std::vector<float> samples(std::size_t(patch_floats(24)));
  load_patch(image, from.below(image.width), from.below(image.height), 24, samples);
  brightest_pixel(image, {double(from.below(300)) - 20.0, double(from.below(200)) - 20.0}, 9);
  track(frame.view, {1, 9.0, lit}, from);
  return 0;
}
