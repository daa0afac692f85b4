/// The twin's GigE Vision camera on this machine's network, and its supervision: plugging in,
/// unplugging by fault, status.
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
  CameraSettings settings;  ///< as in the registers
};

class FakeCamera {
 public:
  /// Errc::unavailable if UDP port 3956 of that address is taken, or no interface has the address.
  static Result<std::unique_ptr<FakeCamera>> plug_in(const CameraConfig& config,
                                                     const CameraDeps& deps);
  ~FakeCamera();
  FakeCamera(const FakeCamera&) = delete;
  FakeCamera& operator=(const FakeCamera&) = delete;

  /// Body of the watch thread: wakes a stalled stream, and unplugs and replugs the camera by fault.
  void work(const std::stop_token& stop);
  /// Aborts the frame in progress. Call it before joining the threads that the frame waits for.
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
  mutable std::mutex mutex_;  ///< held to replace device_, and to read it in other threads
  std::unique_ptr<GigeDevice> device_;
};

}  // namespace ovws::twin
