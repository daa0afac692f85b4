/// The bench's camera on this machine's network: plugged in, watched, unplugged by fault, asked.
#pragma once

#include <memory>
#include <mutex>
#include <stop_token>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_parts.hpp"
#include "drivers/twin/slow_registers.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

class GigeDevice;

struct CameraStatus {
  bool plugged = false;
  bool streaming = false;
  CameraSettings settings;  ///< as the registers say
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
  /// A frame under way ends at once. To be called before the threads that it waits for are joined.
  void request_stop() { stop_.request_stop(); }
  CameraStatus status() const;                        ///< thread-safe
  const FrameTally& tally() const { return tally_; }  ///< thread-safe

 private:
  FakeCamera(const CameraConfig& config, const CameraDeps& deps);
  Result<void> plug();
  void unplug();

  const CameraConfig config_;
  const CameraDeps deps_;
  std::stop_source stop_;
  FrameTally tally_;
  const SlowRegisters slow_registers_;
  mutable std::mutex mutex_;  ///< held while device_ is replaced, and while others read it
  std::unique_ptr<GigeDevice> device_;
};

}  // namespace ovws::twin
