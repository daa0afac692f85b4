#include "drivers/twin/gige_device.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"
#include "drivers/twin/genicam.hpp"
#include "drivers/twin/glib_hooks.hpp"
#include "drivers/twin/pixel_packing.hpp"

namespace ovws::twin {
namespace {

constexpr std::uint16_t kPort = 3956;  // fixed by GigE Vision
constexpr auto kFarFieldTime = std::chrono::milliseconds(400);
constexpr auto kMaxDisplayAge = std::chrono::milliseconds(5);  // then the display is queried again
// Longest wait for a pulse in which no register is served.
constexpr std::int64_t kLongestWaitNs = 20'000'000;
constexpr int kMaxDisplayChecks = 3;  // after more queries the frame is late and is not sent
constexpr auto kDisplayStands = std::chrono::seconds(1);  // without an answer the SLM's image stays

// Bootstrap registers of GigE Vision that hold text.
constexpr std::uint32_t kVendorAddress = 0x48, kModelAddress = 0x68, kInfoAddress = 0xa8;

sockaddr_in camera_address(const std::string& address) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(kPort);
  inet_pton(AF_INET, address.c_str(), &result.sin_addr);
  return result;
}

bool inside(const Roi& roi, const CameraConfig& sensor) {
  // Registers may hold any value: check the ranges first, so that no sum overflows.
  return roi.x >= 0 && roi.y >= 0 && roi.width > 0 && roi.height > 0 &&
         roi.width <= sensor.sensor_width && roi.height <= sensor.sensor_height &&
         roi.x <= sensor.sensor_width - roi.width && roi.y <= sensor.sensor_height - roi.height;
}

/// Pixel memory of a buffer, for a frame of these settings; empty if the buffer has no memory.
std::span<std::byte> pixels_of(ArvBuffer* buffer, const CameraSettings& settings) {
  size_t unused_size = 0;  // Aravis sets the size after `fill`
  const void* pixels = arv_buffer_get_data(buffer, &unused_size);
  if (pixels == nullptr || settings.roi.width <= 0 || settings.roi.height <= 0) return {};
  return {static_cast<std::byte*>(const_cast<void*>(pixels)),
          frame_bytes(settings.pixel_format, settings.roi.width, settings.roi.height)};
}

}  // namespace

Descriptor::~Descriptor() {
  if (fd_ >= 0) close(fd_);
}

int try_camera_port(const std::string& address) {
  const Descriptor probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in at = camera_address(address);
  return bind(probe.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 ? 0 : errno;
}

GigeDevice::GigeDevice(ArvGvFakeCamera* gige, const CameraConfig& config, const CameraDeps& deps,
                       std::stop_token stop, FrameTally& tally)
    : config_(config),
      deps_(deps),
      stop_(std::move(stop)),
      tally_(tally),
      gige_(gige),
      camera_(arv_gv_fake_camera_get_fake_camera(gige)),
      nudger_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  power_up();
  arv_fake_camera_set_fill_pattern(
      camera_,
      [](ArvBuffer* buffer, void* self, guint32, guint32, ArvPixelFormat) {
        static_cast<GigeDevice*>(self)->fill(buffer);
      },
      this);
}

GigeDevice::~GigeDevice() {
  // g_object_set holds a reference for a moment. If it were the last reference, GLib would finalise
  // the camera in the camera's own thread, which cannot join itself. `fill` would then outlive this
  // object.
  {
    const std::lock_guard lock(properties_mutex_);
    ending_ = true;
  }
  g_object_unref(gige_);
}

std::uint32_t GigeDevice::read(std::uint32_t address) const {
  guint32 value = 0;
  arv_fake_camera_read_register(camera_, address, &value);
  return value;
}

void GigeDevice::write(std::uint32_t address, std::uint32_t value) {
  arv_fake_camera_write_register(camera_, address, value);
}

void GigeDevice::write_text(std::uint32_t address, const std::string& text) {
  arv_fake_camera_write_memory(camera_, address, std::uint32_t(text.size() + 1), text.c_str());
}

void GigeDevice::power_up() {
  const CameraSettings defaults;
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, std::uint32_t(config_.sensor_width));
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, std::uint32_t(config_.sensor_height));
  write(ARV_FAKE_CAMERA_REGISTER_WIDTH,
        std::uint32_t(std::min(defaults.roi.width, config_.sensor_width)));
  write(ARV_FAKE_CAMERA_REGISTER_HEIGHT,
        std::uint32_t(std::min(defaults.roi.height, config_.sensor_height)));
  write(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US, std::uint32_t(defaults.exposure_us));
  const auto period_us = std::uint32_t(1e6 / defaults.frame_rate_hz);
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, period_us);
  write(kRegisterWantedPeriodUs, period_us);
  write(kRegisterResultingPeriod10Ns, 100 * period_us);
  write_text(kVendorAddress, kVendorName);
  write_text(kModelAddress, kModelName);
  write_text(kInfoAddress, "digital twin of the ovws bench");
}

bool GigeDevice::streaming() const {
  return arv_fake_camera_get_acquisition_status(camera_) != 0;
}

CameraSettings GigeDevice::settings() const {
  CameraSettings s;
  s.gain_db = kGainStepDb * read(ARV_FAKE_CAMERA_REGISTER_GAIN_RAW);
  s.exposure_us = read(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US);
  s.frame_rate_hz = 1e8 / std::max(1U, read(kRegisterResultingPeriod10Ns));
  s.pixel_format = pixel_format_from_code(read(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT))
                       .value_or(PixelFormat::mono8);
  s.roi = {int(read(ARV_FAKE_CAMERA_REGISTER_X_OFFSET)),
           int(read(ARV_FAKE_CAMERA_REGISTER_Y_OFFSET)), int(read(ARV_FAKE_CAMERA_REGISTER_WIDTH)),
           int(read(ARV_FAKE_CAMERA_REGISTER_HEIGHT))};
  return s;
}

/// Fills the next frame. Runs in Aravis's thread, which then sends the frame. While `fill` runs,
/// the thread serves no registers.
void GigeDevice::fill(ArvBuffer* buffer) {
  filling_ = true;
  if (follow_utc()) next_pulse_ = 0;
  if (read(kRegisterTriggerMode) == 0) {
    run_free(buffer, settings());
  } else {
    run_triggered(buffer, settings());
  }
  filled_ns_ = monotonic_ns();
  filling_ = false;
}

void GigeDevice::run_free(ArvBuffer* buffer, const CameraSettings& settings) {
  // A camera cannot send frames faster than it exposes them.
  const std::uint32_t period_us =
      std::max(read(kRegisterWantedPeriodUs), std::uint32_t(settings.exposure_us));
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, period_us);
  write(kRegisterResultingPeriod10Ns, 100 * period_us);
  send_frame(buffer, settings);
  period_ns_ = std::int64_t(period_us) * 1000;
  // Aravis sends a frame at every multiple of the period.
  end_polls_at((twin_ns() / period_ns_ + 1) * period_ns_);
}

/// One frame for each pulse of the DMD. A pulse that comes during an exposure is missed. Without
/// pulses the camera sends nothing.
void GigeDevice::run_triggered(ArvBuffer* buffer, const CameraSettings& settings) {
  // Aravis calls `fill` again when its thread has polled once.
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1);
  period_ns_ = std::numeric_limits<std::int64_t>::max() / 2;  // nothing to nudge
  const auto& clock = deps_.bench.clock();
  if (!clock || !wait_for_pulse(*clock)) {
    lose_packets(FrameFate::drop);  // of what Aravis sends now; it has no frame number
    return end_polls_at(twin_ns() + kLongestWaitNs);
  }
  const std::int64_t pulse = next_pulse_, t_ns = clock->time_of(pulse);
  next_pulse_ = clock->last_pulse_in(t_ns, settings.exposure_us) + 1;
  const double period_ns = double(next_pulse_ - pulse) * clock->period_ns();
  write(kRegisterResultingPeriod10Ns, std::uint32_t(std::min(period_ns / 10.0, 4e9)));
  arv_buffer_set_timestamp(buffer, std::uint64_t(t_ns));
  send_frame(buffer, settings);
  end_polls_at(std::min(clock->time_of(next_pulse_), twin_ns() + kLongestWaitNs));
}

/// Waits for pulse number next_pulse_. False if it comes later than in kLongestWaitNs. If this
/// thread is late, pulses of the last kMaxPulseAgeNs are served; older ones are missed.
bool GigeDevice::wait_for_pulse(const PatternClock& clock) {
  constexpr std::int64_t kMaxPulseAgeNs = 10'000'000;
  const std::int64_t now_ns = twin_ns();
  if (clock.time_of(next_pulse_) < now_ns - kMaxPulseAgeNs) {
    next_pulse_ = clock.last_pulse(now_ns) + 1;
  }
  const std::int64_t wait_ns = clock.time_of(next_pulse_) - now_ns;
  if (wait_ns > kLongestWaitNs) return false;
  if (wait_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(wait_ns));
  return true;
}

void GigeDevice::send_frame(ArvBuffer* buffer, const CameraSettings& settings) {
  lose_packets(send_again(buffer, settings) ? FrameFate::send : inject_fault(buffer, settings));
}

/// Sends the kept frame if it is due, with its original number and time instead of Aravis's.
/// Returns false if no kept frame is due, or if its size no longer fits: it is then dropped.
bool GigeDevice::send_again(ArvBuffer* buffer, const CameraSettings& settings) {
  if (!kept_ || kept_->others-- > 0) return false;
  const Kept kept = std::move(*kept_);
  kept_.reset();
  const std::span<std::byte> out = pixels_of(buffer, settings);
  if (out.size() != kept.pixels.size()) return false;
  std::memcpy(out.data(), kept.pixels.data(), out.size());
  arv_buffer_set_frame_id(buffer, kept.frame_id);
  arv_buffer_set_timestamp(buffer, kept.t_ns);
  return true;
}

/// Makes a new frame and applies the active fault to this frame.
FrameFate GigeDevice::inject_fault(ArvBuffer* buffer, const CameraSettings& settings) {
  frame_id_ = frame_id_ % 65535 + 1;
  arv_buffer_set_frame_id(buffer, frame_id_);
  const FrameFate fate = kept_ ? FrameFate::send : deps_.faults.next_frame(stop_);
  if (fate == FrameFate::drop) {
    ++tally_.dropped;
    return fate;
  }
  if (take(buffer, settings) == FrameFate::drop) return FrameFate::drop;
  ++(fate == FrameFate::incomplete ? tally_.incomplete : tally_.sent);
  if (fate != FrameFate::duplicate && fate != FrameFate::reorder) return fate;
  const bool swapped = fate == FrameFate::reorder;
  ++(swapped ? tally_.reordered : tally_.duplicated);
  const std::span<std::byte> pixels = pixels_of(buffer, settings);
  kept_ = Kept{
      {pixels.begin(), pixels.end()}, frame_id_, arv_buffer_get_timestamp(buffer), swapped ? 1 : 0};
  return swapped ? FrameFate::drop : FrameFate::send;
}

/// Waits until the bench knows what the X server shows.
GigeDevice::DisplayAnswer GigeDevice::query_display() {
  const auto now = std::chrono::steady_clock::now();
  if (deps_.screen.catch_up(now + kDisplayTime, stop_)) display_answered_ = now;
  if (display_answered_ == now) return DisplayAnswer::known;
  return now - display_answered_ < kDisplayStands ? DisplayAnswer::slow : DisplayAnswer::none;
}

/// An image takes effect at the begin of the DMD's next cycle: in pattern mode the first frame of
/// each cycle queries the display.
bool GigeDevice::is_queried(std::int64_t t_ns) {
  const auto& clock = deps_.bench.clock();
  const std::int64_t cycle = clock ? clock->cycle_of(clock->last_pulse(t_ns)) : 0;
  return std::exchange(queried_cycle_, cycle) != cycle || !clock;
}

FrameFate GigeDevice::take(ArvBuffer* buffer, const CameraSettings& settings) {
  const auto format = pixel_format_from_code(read(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT));
  const std::span<std::byte> out = pixels_of(buffer, settings);
  const bool whole_bytes = format && settings.roi.width % pixels_per_group(*format) == 0;
  if (!whole_bytes || !inside(settings.roi, config_) || out.empty()) {
    ++tally_.refused;
    return FrameFate::drop;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto deadline = start + kFarFieldTime;
  const auto t_ns = std::int64_t(arv_buffer_get_timestamp(buffer));
  const auto& clock = deps_.bench.clock();
  const Exposed exposed = clock ? clock->exposed(t_ns, settings.exposure_us) : Exposed{};
  DisplayAnswer display = is_queried(t_ns) ? query_display() : DisplayAnswer::none;
  // In pattern mode the time of a frame is that of its pulse, so no other moment is computed ahead.
  const std::uint64_t begun = deps_.bench.begin(
      settings.roi, t_ns, clock ? 0 : std::int64_t(1e9 / settings.frame_rate_hz), exposed);
  std::shared_ptr<const Scene> ready;
  auto verified = start;
  int checks = 0;
  while (display != DisplayAnswer::slow) {
    const auto scene = deps_.bench.scene(begun, ready, deadline, stop_);
    if (!scene) break;
    if (scene == ready) {
      const auto now = std::chrono::steady_clock::now();
      if (display == DisplayAnswer::none || now <= verified + kMaxDisplayAge) {
        // Clients look up the ground truth of the turbulence by this time.
        if (scene->truth.turbulence) arv_buffer_set_timestamp(buffer, std::uint64_t(scene->t_ns));
        deps_.bench.note_sent(arv_buffer_get_frame_id(buffer),
                              std::int64_t(arv_buffer_get_timestamp(buffer)), *scene);
        return FrameFate::send;
      }
      // Making the frame took long (busy machine): query the display again, because the SLM image
      // may have changed meanwhile.
      if (++checks > kMaxDisplayChecks) break;
      display = query_display();
      verified = now;
      continue;
    }
    if (!deps_.frames.take({scene, exposed, settings.exposure_us, settings.gain_db, *format},
                           deadline, stop_, out)) {
      break;
    }
    ready = scene;
  }
  ++tally_.late;
  return FrameFate::drop;
}

/// Sets Aravis's ratio of lost packets: 1 for a dropped frame (it keeps its number), 0.5 for an
/// incomplete frame, else 0.
void GigeDevice::lose_packets(FrameFate fate) {
  const double ratio = fate == FrameFate::send ? 0.0 : fate == FrameFate::drop ? 1.0 : 0.5;
  const std::lock_guard lock(properties_mutex_);
  if (ending_ || ratio == lost_ratio_) return;
  g_object_set(gige_, "gvsp-lost-ratio", ratio, nullptr);
  lost_ratio_ = ratio;
}

/// Workaround for a stalled stream in Aravis 0.8.26, which computes the time to the next frame as
/// an unsigned number. If Aravis's thread is a microsecond late, it therefore sleeps for 100 ms.
/// Any packet wakes the thread; this sends a GigE Vision discovery, which has no side effects.
void GigeDevice::nudge_if_stalled() {
  constexpr std::int64_t kLateNs = 2'000'000, kStoppedNs = 300'000'000;
  const std::int64_t late_ns = monotonic_ns() - filled_ns_ - period_ns_;
  if (filling_ || late_ns < kLateNs || late_ns > kStoppedNs || !streaming()) return;
  constexpr unsigned char kDiscovery[] = {0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01};
  const sockaddr_in to = camera_address(config_.address);
  sendto(nudger_.get(), kDiscovery, sizeof kDiscovery, 0, reinterpret_cast<const sockaddr*>(&to),
         sizeof to);
  ++tally_.nudges;
}

}  // namespace ovws::twin
