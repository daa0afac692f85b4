#include "daemon/ovwsd/frames/frame_grabs.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/pixels.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxOpen = 16;
constexpr std::size_t kMaxBytes = 2 * limits::kGrabBytes;

using InUse = std::shared_ptr<std::atomic<std::size_t>>;

/// Reserves memory of all grabs; null if there is not enough left.
std::shared_ptr<void> reserve(const InUse& in_use, std::size_t bytes) {
  if (in_use->fetch_add(bytes) + bytes <= kMaxBytes) {
    return {in_use.get(), [in_use, bytes](void*) { in_use->fetch_sub(bytes); }};
  }
  in_use->fetch_sub(bytes);
  return nullptr;
}

Error replaced(std::int64_t wanted, std::uint64_t by) {
  return {Errc::refused, "after_hologram",
          fmt::format("hologram {} was replaced by hologram {} before enough frames were exposed "
                      "under it",
                      wanted, by)};
}

Error stopping() {
  return {Errc::refused, "", "the daemon is stopping; start it again and repeat the request"};
}

}  // namespace

/// One open grab. Only the images thread calls its methods, after the constructor.
class FrameGrabs::Grab {
 public:
  Grab(const CameraGrab& wish, Done done, InUse in_use, FrameTaps& frames)
      : wish_(wish),
        done_(std::move(done)),
        in_use_(std::move(in_use)),
        asked_ns_(monotonic_ns()),
        tap_(frames, FrameTap::Needs::pixels, wish.frames,
             [this](const FrameRecord& record) { return take(record); }) {}

  /// Ends it with an error, unless it is complete.
  void refuse_rest(Error why) {
    if (!error_ && !tap_.done()) refuse(std::move(why));
  }

  /// Whether it has ended; then it has been answered.
  bool end_if_due(std::uint64_t newest) {
    if (!error_ && !tap_.done()) look_for_errors(newest);
    if (!error_ && !tap_.done()) return false;
    tap_.close();
    if (error_) {
      done_(fail(*error_), nullptr);
    } else {
      done_(std::move(report_), pixels());
    }
    return true;
  }

 private:
  bool take(const FrameRecord& record);
  bool begin(const FrameRecord& record);
  bool wanted(const FrameRecord& record);
  void copy(const ImageView& image);
  void look_for_errors(std::uint64_t newest);
  Pixels pixels();
  bool refuse(Error why) {
    error_ = std::move(why);
    return false;
  }

  const CameraGrab wish_;
  const Done done_;
  const InUse in_use_;
  const std::int64_t asked_ns_;
  Roi roi_;
  ImagePart part_;
  GrabReport report_;
  std::shared_ptr<void> reserved_;   ///< memory; null before the first frame
  std::string bytes_;                ///< pixels of the frames so far, or in the end their mean
  std::vector<std::uint32_t> sums_;  ///< with `average`
  std::optional<Error> error_;
  FrameTap tap_;  ///< uses the members above
};

bool FrameGrabs::Grab::wanted(const FrameRecord& record) {
  if (!record.settings_known) return false;
  if (!wish_.after_hologram) {
    // The end of the exposure is an estimate: it may be half of the longest transfer time earlier.
    const std::int64_t earliest_end_ns = record.t_exposed_mono_ns - record.transfer_ns / 2;
    return earliest_end_ns - std::int64_t(1e3 * record.exposure_us) >= asked_ns_;
  }
  const auto id = std::uint64_t(*wish_.after_hologram);
  if (record.hologram_id > id) return refuse(replaced(*wish_.after_hologram, record.hologram_id));
  return record.still && record.hologram_id == id;
}

bool FrameGrabs::Grab::begin(const FrameRecord& record) {
  const ImageView& image = record.frame.image;
  roi_ = record.roi;
  part_ = wish_.region.value_or(ImagePart{0, 0, image.width, image.height});
  if (part_.x + part_.width > image.width || part_.y + part_.height > image.height) {
    return refuse({Errc::invalid, "region",
                   fmt::format("does not lie in the image of {} x {} pixels: change it, or the "
                               "camera's region of interest",
                               image.width, image.height)});
  }
  report_.format = image.format;
  report_.average = wish_.average;
  report_.shape = {wish_.average ? 1 : wish_.frames, part_.height, part_.width};
  const std::size_t pixels = std::size_t(part_.width) * std::size_t(part_.height);
  const std::size_t bytes = std::size_t(report_.shape[0]) * pixels * report_.pixel_bytes();
  if (bytes > limits::kGrabBytes) {
    return refuse({Errc::invalid, "frames",
                   fmt::format("these frames have {} bytes, more than {}: grab fewer frames, a "
                               "smaller region, or their average",
                               bytes, limits::kGrabBytes)});
  }
  auto reserved = reserve(in_use_, bytes + (wish_.average ? pixels * sizeof(std::uint32_t) : 0));
  if (!reserved) {
    return refuse({Errc::refused, "",
                   "other grabs use the memory for this one: repeat it when they have ended"});
  }
  report_.frames.reserve(std::size_t(wish_.frames));
  bytes_.reserve(bytes);
  if (wish_.average) sums_.assign(pixels, 0);
  reserved_ = std::move(reserved);  // last: if an allocation throws, the next frame begins again
  return true;
}

void FrameGrabs::Grab::copy(const ImageView& image) {
  visit_rows(
      image, part_.x, part_.y, part_.width, part_.height,
      [&](int x, int y, const auto* pixels, int count) {
        if (!wish_.average) {
          bytes_.append(reinterpret_cast<const char*>(pixels), std::size_t(count) * sizeof *pixels);
          return;
        }
        std::uint32_t* const sums =
            &sums_[std::size_t(y - part_.y) * std::size_t(part_.width) + std::size_t(x - part_.x)];
        for (int i = 0; i < count; ++i) sums[i] += pixels[i];
      });
}

bool FrameGrabs::Grab::take(const FrameRecord& record) {
  if (error_ || !wanted(record)) return false;
  const ImageView& image = record.frame.image;
  if (!reserved_ && !begin(record)) return false;
  const bool fits = part_.x + part_.width <= image.width && part_.y + part_.height <= image.height;
  if (!fits || record.roi != roi_ || image.format != report_.format) {
    return refuse({Errc::refused, "", "the camera's image changed: repeat the request"});
  }
  const auto same_light = [&record](const GrabStamp& first) {
    return first.exposure_us == record.exposure_us && same_number(first.gain_db, record.gain_db) &&
           same_number(first.gain_raw, record.gain_raw);
  };
  if (wish_.average && !report_.frames.empty() && !same_light(report_.frames.front())) {
    return refuse({Errc::refused, "", "exposure or gain changed: repeat the request"});
  }
  const bool of_sequence = record.pattern >= 0 || !record.plan->patterns.empty();
  if (wish_.average && of_sequence) {
    return refuse({Errc::refused, "average",
                   "the frames show different patterns of a sequence: grab them without average"});
  }
  copy(image);
  const auto pattern = record.pattern < 0 ? std::nullopt : std::optional(record.pattern);
  const bool settled = record.still && record.plan->patterns.empty();
  report_.frames.push_back({record.frame.frame_id, record.hologram_id, settled, pattern,
                            record.frame.t_device_ns, record.frame.t_arrival_ns, record.exposure_us,
                            record.gain_db, record.gain_raw});
  return true;
}

void FrameGrabs::Grab::look_for_errors(std::uint64_t newest) {
  if (1e-9 * double(monotonic_ns() - asked_ns_) < wish_.timeout_s) return;
  if (wish_.after_hologram && newest != 0 && newest != std::uint64_t(*wish_.after_hologram)) {
    error_ = replaced(*wish_.after_hologram, newest);
    return;
  }
  error_ = Error{Errc::unavailable, "",
                 fmt::format("{} of {} frames came within {} s: check camera and SLM in "
                             "system.status, or give a longer timeout_s",
                             tap_.used(), wish_.frames, wish_.timeout_s)};
}

FrameGrabs::Pixels FrameGrabs::Grab::pixels() {
  if (wish_.average) {
    bytes_.resize(sums_.size() * sizeof(float));
    for (std::size_t k = 0; k < sums_.size(); ++k) {
      const float mean = float(double(sums_[k]) / wish_.frames);
      std::memcpy(&bytes_[k * sizeof mean], &mean, sizeof mean);
    }
  }
  return {new std::string(std::move(bytes_)),
          [reserved = reserved_](const std::string* sent) { delete sent; }};
}

FrameGrabs::FrameGrabs(FrameTaps& frames, std::function<std::uint64_t()> newest)
    : frames_(frames), newest_(std::move(newest)) {}

FrameGrabs::~FrameGrabs() = default;

void FrameGrabs::grab(const CameraGrab& wish, Done done) {
  const std::uint64_t newest = newest_();
  if (wish.after_hologram && newest == 0) {
    return done(fail(Errc::unavailable, "after_hologram",
                     "the SLM's display is not in use: check slm in system.status"),
                nullptr);
  }
  if (wish.after_hologram && std::uint64_t(*wish.after_hologram) != newest) {
    const bool future = std::uint64_t(*wish.after_hologram) > newest;
    return done(fail(Errc::refused, "after_hologram",
                     fmt::format("hologram {} is not on the SLM{}: the newest one is {}",
                                 *wish.after_hologram, future ? " yet" : " any more", newest)),
                nullptr);
  }
  const std::lock_guard lock(mutex_);
  if (open_.size() >= kMaxOpen) {
    return done(fail(Errc::refused, "",
                     "too many grabs wait for frames: repeat the request when one has ended"),
                nullptr);
  }
  open_.push_back(std::make_unique<Grab>(wish, std::move(done), bytes_in_use_, frames_));
}

void FrameGrabs::end_due() {
  const std::lock_guard lock(mutex_);
  if (open_.empty()) return;
  const std::uint64_t newest = newest_();
  if (ending_) {
    for (const auto& grab : open_) grab->refuse_rest(stopping());
  }
  std::erase_if(open_, [&](const auto& grab) { return grab->end_if_due(newest); });
}

}  // namespace ovws
