#include "drivers/twin/fake_camera.hpp"

#include <arpa/inet.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "drivers/twin/genicam.hpp"
#include "drivers/twin/gige_device.hpp"
#include "drivers/twin/glib_hooks.hpp"

namespace ovws::twin {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(5);
constexpr auto kBetweenPlugs = std::chrono::milliseconds(200);

/// The GenICam description as an in-memory file (memfd), because Aravis reads it from a file.
std::unique_ptr<Descriptor> genicam_file() {
  auto file = std::make_unique<Descriptor>(memfd_create("ovws-twin.xml", MFD_CLOEXEC));
  const std::string_view xml = genicam_xml();
  const bool written = write(file->get(), xml.data(), xml.size()) == ssize_t(xml.size());
  return written ? std::move(file) : nullptr;
}

tl::unexpected<Error> no_camera(const std::string& reason) {
  return fail(Errc::unavailable, "camera.address", reason);
}

}  // namespace

FakeCamera::FakeCamera(const CameraConfig& config, const CameraDeps& deps)
    : config_(config), deps_(deps) {
  delay_registers(&deps.faults);
}

FakeCamera::~FakeCamera() {
  delay_registers(nullptr);
  request_stop();
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
  if (try_camera_port(address) == EADDRINUSE) {
    return no_camera("UDP " + address +
                     ":3956 is taken: another GigE Vision camera or twin runs on this machine?");
  }
  const auto file = genicam_file();
  if (!file) return fail(Errc::internal, "", "not enough memory for the camera's description");
  const std::string path = "/proc/self/fd/" + std::to_string(file->get());
  ArvGvFakeCamera* gige =
      arv_gv_fake_camera_new_full(address.c_str(), config_.serial.c_str(), path.c_str());
  auto device = std::make_unique<GigeDevice>(gige, config_, deps_, stop_.get_token(), tally_);
  if (!arv_gv_fake_camera_is_running(gige)) {
    return no_camera("no network interface of this machine has the address " + address +
                     ": choose one that `ip address` lists");
  }
  // Aravis reports a running camera even if it could not bind the port, so ask the kernel.
  if (try_camera_port(address) != EADDRINUSE) {
    return no_camera("the camera could not listen on UDP " + address + ":3956");
  }
  const std::lock_guard lock(mutex_);
  device_ = std::move(device);
  return {};
}

/// Removes the camera from the network. Joining Aravis's thread takes up to one frame time, so it
/// happens after the lock is released: `status` then does not block.
void FakeCamera::unplug() {
  std::unique_ptr<GigeDevice> device;
  {
    const std::lock_guard lock(mutex_);
    device = std::move(device_);
  }
}

void FakeCamera::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(kWatchPeriod);
    const bool unplugged = deps_.faults.unplugged();
    if (device_ && unplugged) {
      unplug();
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
  const std::lock_guard lock(mutex_);
  status.plugged = device_ != nullptr;
  if (device_) {
    status.streaming = device_->streaming();
    status.settings = device_->settings();
  }
  return status;
}

}  // namespace ovws::twin
