/// GigE Vision camera of the twin on this machine's network: plugging in, unplugging by an injected
/// fault, status.
#pragma once

#include <memory>
#include <mutex>
#include <stop_token>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/camera_parts.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

class GigeDevice;

struct CameraStatus {
  bool plugged = false;
  bool streaming = false;
  CameraSettings settings;  ///< read from the camera's registers
};

class FakeCamera {
 public:
  /// Connects the camera to the network. Errc::unavailable if UDP port 3956 of `config.address` is
  /// taken or no interface has this address; Errc::invalid if it is not an IPv4 address.
  static Result<std::unique_ptr<FakeCamera>> plug_in(const CameraConfig& config,
                                                     const CameraDeps& deps);
  ~FakeCamera();
  FakeCamera(const FakeCamera&) = delete;
  FakeCamera& operator=(const FakeCamera&) = delete;

  /// Body of the watch thread: wakes a stalled stream, unplugs the camera while the fault `unplug`
  /// is active, and plugs it in again afterwards.
  void work(const std::stop_token& stop);
  /// Aborts the frame in progress. Call this before joining the threads that the frame waits for.
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
  mutable std::mutex mutex_;  ///< guards device_: held to replace it or use it in other threads
  std::unique_ptr<GigeDevice> device_;
};

}  // namespace ovws::twin
