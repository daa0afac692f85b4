/// The bench's camera: a GigE Vision camera on this machine's network that shows what falls on the
/// twin's sensor. Aravis headers stay in the .cpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/screen.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

struct CameraStatus {
  bool plugged = false;
  bool streaming = false;
  CameraSettings settings;  ///< as the registers say
  std::uint64_t sent = 0;
  std::uint64_t dropped = 0, incomplete = 0;  ///< by a fault that was ordered
  std::uint64_t late = 0;                     ///< not sent: the far field was not ready in time
  std::uint64_t refused = 0;  ///< not sent: ROI outside the sensor, or a pixel format unknown
  std::uint64_t nudges = 0;   ///< times that the stream had to be woken (see Nudge in the .cpp)
};

struct CameraDeps {
  Bench& bench;
  FrameSource& frames;
  Faults& faults;
  Screen& screen;
};

class FakeCamera {
 public:
  /// Errc::unavailable if UDP port 3956 of that address is taken, or no interface has the address.
  static Result<std::unique_ptr<FakeCamera>> plug_in(const CameraConfig& config,
                                                     const CameraDeps& deps);
  ~FakeCamera();
  FakeCamera(const FakeCamera&) = delete;
  FakeCamera& operator=(const FakeCamera&) = delete;

  /// Body of the camera's watch thread: keeps the stream in step, unplugs and plugs in by fault.
  void work(const std::stop_token& stop);
  /// Frames under way end at once. To be called before the bench and the noise threads end.
  void request_stop();
  CameraStatus status() const;  ///< thread-safe

 private:
  struct Device;
  struct Counts {
    std::atomic<std::uint64_t> sent{0}, dropped{0}, incomplete{0}, late{0}, refused{0}, nudges{0};
  };
  FakeCamera(const CameraConfig& config, const CameraDeps& deps);
  Result<void> plug();

  const CameraConfig config_;
  const CameraDeps deps_;
  std::stop_source stop_;
  Counts counts_;
  mutable std::mutex mutex_;  ///< held while device_ is replaced or read
  std::unique_ptr<Device> device_;
};

}  // namespace ovws::twin
