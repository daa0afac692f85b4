#include "drivers/replay/replay_camera.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>

#include "core/base/printable.hpp"
#include "core/port/clock.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {
namespace {

constexpr int kBuffers = 16;
constexpr Range<double> kRateHz{0.01, 10'000.0, 0.0};

/// Frame numbers made monotonic: where the recorded camera was reopened and restarted its count,
/// the numbers continue after the last number.
std::vector<std::uint64_t> rising_ids(const std::vector<RecordedFrame>& frames) {
  std::vector<std::uint64_t> ids;
  std::uint64_t offset = 0;
  for (const RecordedFrame& frame : frames) {
    if (!ids.empty() && frame.frame_id + offset <= ids.back())
      offset = ids.back() + 1 - frame.frame_id;
    ids.push_back(frame.frame_id + offset);
  }
  return ids;
}

class ReplayCamera final : public Camera {
 public:
  ReplayCamera(const std::string& path, std::unique_ptr<RecordingReader> reader)
      : reader_(std::move(reader)) {
    const RecordingHeader& header = reader_->header();
    info_ = {printable(header.vendor, kMaxNameBytes), printable(header.model, kMaxNameBytes),
             printable(header.serial, kMaxNameBytes), path};
    for (const RecordedFrame& frame : reader_->frames()) {
      if (frame.picture >= 0) frames_.push_back(frame);
    }
    ids_ = rising_ids(frames_);
    const auto known = std::find_if(frames_.begin(), frames_.end(),
                                    [](const auto& frame) { return frame.settings_known != 0; });
    const RecordedFrame& first = known == frames_.end() ? frames_.front() : *known;
    settings_ = {first.gain_db,
                 first.exposure_us,
                 header.frame_rate_hz,
                 header.format,
                 {header.x, header.y, header.width, header.height},
                 first.gain_raw};
    for (auto& buffer : buffers_) buffer.resize(reader_->image_bytes());
  }

  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override;
  Result<CameraSettings> apply(const CameraSettings& wanted) override;
  Result<void> start() override;
  void stop() override { streaming_ = false; }
  bool alive() const override { return alive_.load(); }
  int buffer_count() const override { return kBuffers; }
  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) override;
  void release(int slot) OVWS_NONBLOCKING override { lent_[std::size_t(slot)].store(false); }

 private:
  bool prepare();
  /// Due time of the next frame by the current rate, which may have changed since the previous
  /// frame.
  std::int64_t due_mono_ns() const { return last_due_mono_ns_ + period_ns_.load(); }

  std::unique_ptr<RecordingReader> reader_;
  CameraInfo info_;
  CameraSettings settings_;
  std::vector<RecordedFrame> frames_;  ///< frames with images; never empty
  std::vector<std::uint64_t> ids_;     ///< frame numbers of frames_
  std::array<std::vector<std::byte>, kBuffers> buffers_;
  std::array<std::atomic<bool>, kBuffers> lent_{};
  std::atomic<bool> alive_{true};
  std::atomic<std::int64_t> period_ns_{10'000'000};
  // Used by the acquisition thread, and by `start` and `stop`, which exclude stream calls.
  bool streaming_ = false;
  std::size_t next_ = 0;
  std::uint64_t round_ids_ = 0;  ///< offset of this round's frame numbers to the first round's
  int prepared_ = -1;            ///< buffer that holds the next image; -1: none
  std::int64_t last_due_mono_ns_ = 0;
};

Result<CameraLimits> ReplayCamera::limits() {
  CameraLimits limits;
  limits.gain_db = {-100.0, 100.0, 0.0};
  if (std::isnan(settings_.gain_db)) limits.gain_raw = {-1e9, 1e9, 0.0};
  limits.exposure_us = {0.0, 1e9, 0.0};
  limits.frame_rate_hz = kRateHz;
  limits.roi_width = {settings_.roi.width, settings_.roi.width, 1};
  limits.roi_height = {settings_.roi.height, settings_.roi.height, 1};
  limits.sensor_width = settings_.roi.x + settings_.roi.width;
  limits.sensor_height = settings_.roi.y + settings_.roi.height;
  limits.pixel_formats = {settings_.pixel_format};
  return limits;
}

Result<CameraSettings> ReplayCamera::apply(const CameraSettings& wanted) {
  if (!(wanted.roi == settings_.roi)) {
    return fail(Errc::invalid, "camera.roi",
                "the recording's region is " + std::to_string(settings_.roi.width) + " x " +
                    std::to_string(settings_.roi.height) + " at " +
                    std::to_string(settings_.roi.x) + ", " + std::to_string(settings_.roi.y) +
                    ": set this one");
  }
  if (wanted.pixel_format != settings_.pixel_format) {
    return fail(Errc::invalid, "camera.pixel_format",
                "the recording's format is " +
                    std::string(pixel_format_name(settings_.pixel_format)) + ": set this one");
  }
  if (!(wanted.frame_rate_hz >= kRateHz.min && wanted.frame_rate_hz <= kRateHz.max)) {
    return fail(Errc::invalid, "camera.frame_rate_hz",
                "must be 0.01 to 10000 frames/s for a replay");
  }
  settings_.frame_rate_hz = wanted.frame_rate_hz;
  period_ns_.store(std::llround(1e9 / wanted.frame_rate_hz));
  return settings_;
}

Result<void> ReplayCamera::start() {
  if (streaming_)
    return fail(Errc::refused, "camera",
                "program error: the camera was started twice; restart ovwsd");
  streaming_ = true;
  prepared_ = -1;
  last_due_mono_ns_ = monotonic_ns() - period_ns_.load();
  for (auto& lent : lent_) lent.store(false);
  return {};
}

/// Reads the next image ahead of its due time, because reading takes about a millisecond.
bool ReplayCamera::prepare() {
  if (prepared_ >= 0) return true;
  const auto free = std::find_if(lent_.begin(), lent_.end(), [](const auto& one) { return !one; });
  if (free == lent_.end()) return false;
  const auto slot = std::size_t(free - lent_.begin());
  if (!reader_->picture(frames_[next_], buffers_[slot])) {
    alive_.store(false);
    return false;
  }
  prepared_ = int(slot);
  return true;
}

GrabStatus ReplayCamera::grab(GrabbedFrame& out, std::chrono::microseconds timeout) {
  const std::int64_t until = monotonic_ns() + std::chrono::nanoseconds(timeout).count();
  const std::int64_t due_ns = due_mono_ns();
  if (!alive_ || !streaming_ || !prepare() || due_ns > until) {
    std::this_thread::sleep_for(
        std::chrono::nanoseconds(std::max<std::int64_t>(until - monotonic_ns(), 0)));
    return GrabStatus::timeout;
  }
  std::this_thread::sleep_for(
      std::chrono::nanoseconds(std::max<std::int64_t>(due_ns - monotonic_ns(), 0)));
  const RecordedFrame& frame = frames_[next_];
  const RecordingHeader& header = reader_->header();
  const std::size_t bytes = row_bytes(header.format, header.width);
  out.image = {buffers_[std::size_t(prepared_)].data(),
               header.width,
               header.height,
               std::ptrdiff_t(bytes),
               header.format,
               frame.left_justified_bits};
  out.justification_known = true;
  out.frame_id = ids_[next_] + round_ids_;
  out.t_arrival_mono_ns = monotonic_ns();
  out.t_arrival_ns = utc_ns();
  out.t_device_ns = due_ns;
  out.slot = prepared_;
  lent_[std::size_t(prepared_)].store(true);
  prepared_ = -1;
  if (++next_ == frames_.size()) {
    round_ids_ += ids_.back() - ids_.front() + 1;
    next_ = 0;
  }
  // If the replay cannot keep the rate, it continues as fast as it can and does not catch up.
  last_due_mono_ns_ = std::max(due_ns, out.t_arrival_mono_ns - period_ns_.load());
  return GrabStatus::frame;
}

}  // namespace

Result<std::unique_ptr<Camera>> open_replay_camera(const std::string& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) return fail(reader.error().code, "camera.id", reader.error().reason);
  const auto& frames = (*reader)->frames();
  const bool any = std::any_of(frames.begin(), frames.end(),
                               [](const RecordedFrame& frame) { return frame.picture >= 0; });
  if (!any) {
    return fail(Errc::invalid, "camera.id",
                path + ": holds no images, so there is nothing to replay");
  }
  return std::make_unique<ReplayCamera>(path, std::move(*reader));
}

}  // namespace ovws
