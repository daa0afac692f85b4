#include "drivers/twin/fake_camera.hpp"

#include <arpa/inet.h>
#include <arv.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <thread>

#include "core/port/clock.hpp"
#include "drivers/twin/genicam.hpp"

namespace ovws::twin {
namespace {

constexpr std::uint16_t kPort = 3956;  // fixed by GigE Vision
constexpr auto kFarFieldTime = std::chrono::milliseconds(400);
constexpr auto kDisplayTime = std::chrono::milliseconds(200);
constexpr auto kBetweenPlugs = std::chrono::milliseconds(200);

// Bootstrap registers of GigE Vision that hold text.
constexpr std::uint32_t kVendorAddress = 0x48, kModelAddress = 0x68, kInfoAddress = 0xa8;

/// A file descriptor that closes itself.
struct Descriptor {
  int value = -1;
  explicit Descriptor(int fd) : value(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value >= 0) close(value);
  }
};

sockaddr_in camera_address(const std::string& address) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(kPort);
  inet_pton(AF_INET, address.c_str(), &result.sin_addr);
  return result;
}

/// Aravis says that its camera runs even where it could not have the port: so ask the kernel.
/// Returns 0 if the port is free, else errno.
int try_port(const std::string& address) {
  const Descriptor probe(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in at = camera_address(address);
  return bind(probe.value, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 ? 0 : errno;
}

tl::unexpected<Error> no_camera(const std::string& reason) {
  return fail(Errc::unavailable, "camera.address", reason);
}

/// Aravis reads the description from a file: give it one that exists in memory only.
std::unique_ptr<Descriptor> genicam_file() {
  auto file = std::make_unique<Descriptor>(memfd_create("ovws-twin.xml", MFD_CLOEXEC));
  const std::string_view xml = genicam_xml();
  const bool whole = write(file->value, xml.data(), xml.size()) == ssize_t(xml.size());
  return whole ? std::move(file) : nullptr;
}

std::optional<PixelFormat> pixel_format(std::uint32_t code) {
  switch (code) {
    case ARV_PIXEL_FORMAT_MONO_8:
      return PixelFormat::mono8;
    case ARV_PIXEL_FORMAT_MONO_10:
      return PixelFormat::mono10;
    case ARV_PIXEL_FORMAT_MONO_12:
      return PixelFormat::mono12;
    case ARV_PIXEL_FORMAT_MONO_16:
      return PixelFormat::mono16;
    default:
      return std::nullopt;
  }
}

std::uint32_t read_register(ArvFakeCamera* camera, std::uint32_t address) {
  guint32 value = 0;
  arv_fake_camera_read_register(camera, address, &value);
  return value;
}

void write_text(ArvFakeCamera* camera, std::uint32_t address, const std::string& text) {
  arv_fake_camera_write_memory(camera, address, std::uint32_t(text.size() + 1), text.c_str());
}

/// The registers as a camera has them after power-up.
void power_up(ArvFakeCamera* camera, const CameraConfig& config) {
  const CameraSettings settings;
  const auto write = [camera](std::uint32_t address, std::uint32_t value) {
    arv_fake_camera_write_register(camera, address, value);
  };
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, std::uint32_t(config.sensor_width));
  write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, std::uint32_t(config.sensor_height));
  write(ARV_FAKE_CAMERA_REGISTER_WIDTH, std::uint32_t(std::min(512, config.sensor_width)));
  write(ARV_FAKE_CAMERA_REGISTER_HEIGHT, std::uint32_t(std::min(512, config.sensor_height)));
  write(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US, std::uint32_t(settings.exposure_us));
  const auto period_us = std::uint32_t(1e6 / settings.frame_rate_hz);
  write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, period_us);
  write(kRegisterWantedPeriodUs, period_us);
  write_text(camera, kVendorAddress, kVendorName);
  write_text(camera, kModelAddress, kModelName);
  write_text(camera, kInfoAddress, "digital twin of the ovws bench");
}

CameraSettings settings_of(ArvFakeCamera* camera) {
  const auto read = [camera](std::uint32_t address) { return read_register(camera, address); };
  CameraSettings s;
  s.gain_db = kGainStepDb * read(ARV_FAKE_CAMERA_REGISTER_GAIN_RAW);
  s.exposure_us = read(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US);
  s.frame_rate_hz = 1e6 / std::max(1U, read(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US));
  s.pixel_format =
      pixel_format(read(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT)).value_or(PixelFormat::mono8);
  s.roi = {int(read(ARV_FAKE_CAMERA_REGISTER_X_OFFSET)),
           int(read(ARV_FAKE_CAMERA_REGISTER_Y_OFFSET)), int(read(ARV_FAKE_CAMERA_REGISTER_WIDTH)),
           int(read(ARV_FAKE_CAMERA_REGISTER_HEIGHT))};
  return s;
}

bool inside(const Roi& roi, const CameraConfig& sensor) {
  // Unsigned registers may hold anything, so nothing is added before it is known to be small.
  return roi.x >= 0 && roi.y >= 0 && roi.width > 0 && roi.height > 0 &&
         roi.width <= sensor.sensor_width && roi.height <= sensor.sensor_height &&
         roi.x <= sensor.sensor_width - roi.width && roi.y <= sensor.sensor_height - roi.height;
}

}  // namespace

/// One life of the camera, from plugging in to unplugging.
struct FakeCamera::Device {
  Device(FakeCamera& owner_, ArvGvFakeCamera* gige_);
  ~Device() { g_object_unref(gige); }  // ends Aravis's thread first
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void fill(ArvBuffer* buffer);
  FrameFate take(ArvBuffer* buffer, const CameraSettings& settings);
  void lose_packets(FrameFate fate);
  void nudge_if_stalled();

  FakeCamera& owner;
  ArvGvFakeCamera* gige;
  ArvFakeCamera* camera;
  double lost_ratio = 0.0;
  std::atomic<bool> filling{false};
  std::atomic<std::int64_t> filled_ns{0}, period_ns{0};
  Descriptor nudger;
};

FakeCamera::Device::Device(FakeCamera& owner_, ArvGvFakeCamera* gige_)
    : owner(owner_),
      gige(gige_),
      camera(arv_gv_fake_camera_get_fake_camera(gige_)),
      nudger(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  power_up(camera, owner.config_);
  arv_fake_camera_set_fill_pattern(
      camera,
      [](ArvBuffer* buffer, void* self, guint32, guint32, ArvPixelFormat) {
        static_cast<Device*>(self)->fill(buffer);
      },
      this);
}

/// In Aravis's thread, which also sends the frame afterwards and answers registers.
void FakeCamera::Device::fill(ArvBuffer* buffer) {
  filling = true;
  CameraSettings settings = settings_of(camera);
  // No camera sends frames faster than it exposes them.
  const std::uint32_t period_us =
      std::max(read_register(camera, kRegisterWantedPeriodUs), std::uint32_t(settings.exposure_us));
  arv_fake_camera_write_register(camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                 period_us);
  FrameFate fate = owner.deps_.faults.next_frame(owner.stop_.get_token());
  if (fate == FrameFate::drop) ++owner.counts_.dropped;
  if (fate != FrameFate::drop && take(buffer, settings) == FrameFate::drop) fate = FrameFate::drop;
  if (fate == FrameFate::incomplete) ++owner.counts_.incomplete;
  if (fate != FrameFate::drop) ++owner.counts_.sent;
  lose_packets(fate);
  period_ns = std::int64_t(period_us) * 1000;
  filled_ns = monotonic_ns();
  filling = false;
}

FrameFate FakeCamera::Device::take(ArvBuffer* buffer, const CameraSettings& settings) {
  const auto format = pixel_format(read_register(camera, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT));
  size_t size_unknown_here = 0;
  auto* pixels = static_cast<const std::byte*>(arv_buffer_get_data(buffer, &size_unknown_here));
  if (!format || !inside(settings.roi, owner.config_) || pixels == nullptr) {
    ++owner.counts_.refused;
    return FrameFate::drop;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto deadline = start + kFarFieldTime;
  const auto stop = owner.stop_.get_token();
  // A server that hangs shows nothing new: then go by what is known.
  owner.deps_.screen.catch_up(start + kDisplayTime, stop);
  const auto scene = owner.deps_.bench.scene(settings.roi, deadline, stop);
  const std::size_t size = std::size_t(settings.roi.width) * std::size_t(settings.roi.height) *
                           std::size_t(bytes_per_pixel(*format));
  const std::span<std::byte> out(const_cast<std::byte*>(pixels), size);
  if (scene && owner.deps_.frames.take({scene, settings.exposure_us, settings.gain_db, *format},
                                       deadline, stop, out)) {
    return FrameFate::send;
  }
  ++owner.counts_.late;
  return FrameFate::drop;
}

/// A frame that must not be seen is numbered and sent without its packets.
void FakeCamera::Device::lose_packets(FrameFate fate) {
  const double ratio = fate == FrameFate::send ? 0.0 : fate == FrameFate::drop ? 1.0 : 0.5;
  if (ratio == lost_ratio) return;
  g_object_set(gige, "gvsp-lost-ratio", ratio, nullptr);
  lost_ratio = ratio;
}

/// Aravis 0.8.26 computes the time to the next frame as an unsigned number: when its thread is
/// late by a microsecond it sleeps for 100 ms instead of not at all. Any packet wakes it, and a
/// GigE Vision discovery asks for nothing.
void FakeCamera::Device::nudge_if_stalled() {
  constexpr std::int64_t kLateNs = 2'000'000, kStoppedNs = 300'000'000;
  const std::int64_t late_ns = monotonic_ns() - filled_ns - period_ns;
  if (filling || late_ns < kLateNs || late_ns > kStoppedNs) return;
  if (arv_fake_camera_get_acquisition_status(camera) == 0) return;
  constexpr unsigned char kDiscovery[] = {0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01};
  const sockaddr_in to = camera_address(owner.config_.address);
  sendto(nudger.value, kDiscovery, sizeof kDiscovery, 0, reinterpret_cast<const sockaddr*>(&to),
         sizeof to);
  ++owner.counts_.nudges;
}

FakeCamera::FakeCamera(const CameraConfig& config, const CameraDeps& deps)
    : config_(config), deps_(deps) {}

FakeCamera::~FakeCamera() {
  request_stop();
}

void FakeCamera::request_stop() {
  stop_.request_stop();
}

Result<std::unique_ptr<FakeCamera>> FakeCamera::plug_in(const CameraConfig& config,
                                                        const CameraDeps& deps) {
  std::unique_ptr<FakeCamera> camera(new FakeCamera(config, deps));
  if (auto done = camera->plug(); !done) return fail(done.error());
  return camera;
}

Result<void> FakeCamera::plug() {
  const std::string& address = config_.address;
  in_addr parsed{};
  if (inet_pton(AF_INET, address.c_str(), &parsed) != 1) {
    return fail(Errc::invalid, "camera.address", "'" + address + "' is not an IPv4 address");
  }
  if (try_port(address) == EADDRINUSE) {
    return no_camera("UDP " + address + ":" + std::to_string(kPort) +
                     " is taken: another GigE Vision camera or twin runs on this machine?");
  }
  const auto file = genicam_file();
  if (!file) return fail(Errc::internal, "", "no memory for the camera's description");
  const std::string path = "/proc/self/fd/" + std::to_string(file->value);
  ArvGvFakeCamera* gige =
      arv_gv_fake_camera_new_full(config_.address.c_str(), config_.serial.c_str(), path.c_str());
  auto device = std::make_unique<Device>(*this, gige);
  if (!arv_gv_fake_camera_is_running(gige)) {
    return no_camera("no network interface of this machine has the address " + address);
  }
  if (try_port(address) != EADDRINUSE) {
    return no_camera("the camera could not listen on UDP " + address + ":" + std::to_string(kPort));
  }
  const std::lock_guard lock(mutex_);
  device_ = std::move(device);
  return {};
}

void FakeCamera::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const bool unplugged = deps_.faults.unplugged();
    if (device_ && unplugged) {
      std::unique_ptr<Device> gone;
      const std::lock_guard lock(mutex_);
      gone = std::move(device_);
    } else if (!device_ && !unplugged) {
      if (const auto done = plug(); !done) {
        spdlog::warn("camera: {}", done.error().reason);
        std::this_thread::sleep_for(kBetweenPlugs);
      }
    } else if (device_) {
      device_->nudge_if_stalled();
    }
  }
}

CameraStatus FakeCamera::status() const {
  CameraStatus status;
  status.sent = counts_.sent;
  status.dropped = counts_.dropped;
  status.incomplete = counts_.incomplete;
  status.late = counts_.late;
  status.refused = counts_.refused;
  status.nudges = counts_.nudges;
  const std::lock_guard lock(mutex_);
  status.plugged = device_ != nullptr;
  if (device_) {
    status.streaming = arv_fake_camera_get_acquisition_status(device_->camera) != 0;
    status.settings = settings_of(device_->camera);
  }
  return status;
}

}  // namespace ovws::twin
