/// GigE Vision device on Aravis's fake camera: one object from plugging in to unplugging. Only
/// FakeCamera includes this header, because it exposes Aravis's types.
#pragma once

#include <arv.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/twin/camera_parts.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// RAII owner of a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

/// Tries to bind the camera's UDP port (3956). Returns 0 on success, else errno.
int try_camera_port(const std::string& address);

class GigeDevice {
 public:
  /// Takes ownership of `gige`. Aravis's thread calls `fill` from now on.
  GigeDevice(ArvGvFakeCamera* gige, const CameraConfig& config, const CameraDeps& deps,
             std::stop_token stop, FrameTally& tally);
  ~GigeDevice();  ///< ends Aravis's thread
  GigeDevice(const GigeDevice&) = delete;
  GigeDevice& operator=(const GigeDevice&) = delete;

  // The following functions may be called in any thread.
  bool streaming() const;
  CameraSettings settings() const;  ///< read from the camera's registers

  /// Wakes a stalled stream. Called in the watch thread about every millisecond.
  void nudge_if_stalled();

 private:
  void power_up();
  void fill(ArvBuffer* buffer);
  void run_free(ArvBuffer* buffer, const CameraSettings& settings);
  void run_triggered(ArvBuffer* buffer, const CameraSettings& settings);
  bool wait_for_pulse(const PatternClock& clock);
  void send_frame(ArvBuffer* buffer, const CameraSettings& settings);
  bool send_again(ArvBuffer* buffer, const CameraSettings& settings);
  FrameFate inject_fault(ArvBuffer* buffer, const CameraSettings& settings);
  FrameFate take(ArvBuffer* buffer, const CameraSettings& settings);
  /// slow: the X server may show a newer image; none: it was not queried, or stands still.
  enum class DisplayAnswer { known, slow, none };
  DisplayAnswer query_display();
  bool is_queried(std::int64_t t_ns);
  void lose_packets(FrameFate fate);
  std::uint32_t read(std::uint32_t address) const;
  void write(std::uint32_t address, std::uint32_t value);
  void write_text(std::uint32_t address, const std::string& text);

  const CameraConfig& config_;
  const CameraDeps deps_;
  const std::stop_token stop_;
  FrameTally& tally_;
  ArvGvFakeCamera* const gige_;
  ArvFakeCamera* const camera_;
  Descriptor nudger_;
  /// Frame kept for later delivery (faults duplicate and reorder), after `others` more frames.
  struct Kept {
    std::vector<std::byte> pixels;
    std::uint64_t frame_id = 0;
    std::uint64_t t_ns = 0;
    int others = 0;
  };

  // Used by Aravis's thread only, in `fill` and the functions that `fill` calls.
  double lost_ratio_ = 0.0;
  std::uint64_t frame_id_ = 0;      ///< number of the newest frame
  std::int64_t next_pulse_ = 0;     ///< the first one that the camera is ready for
  std::int64_t queried_cycle_ = 0;  ///< of the DMD, in which the display was queried
  std::chrono::steady_clock::time_point display_answered_;  ///< query of the last answer
  std::optional<Kept> kept_;
  std::mutex properties_mutex_;
  bool ending_ = false;  ///< guarded by properties_mutex_; true: set no more properties
  std::atomic<bool> filling_{false};
  std::atomic<std::int64_t> filled_ns_{0}, period_ns_{0};
};

}  // namespace ovws::twin
