/// The camera port: the interface that camera drivers implement.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct Roi {
  int x = 0, y = 0, width = 512, height = 512;  ///< sensor pixels
  friend bool operator==(const Roi&, const Roi&) = default;
};

/// Unknown gain: NaN marks a gain that is not known, or a gain unit that the camera does not have.
inline constexpr double kUnknownGain = std::numeric_limits<double>::quiet_NaN();

/// Whether a and b are equal, or both are NaN (unknown).
inline bool same_number(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

struct CameraSettings {
  /// Gain in dB. A camera that has gain_raw instead reports kUnknownGain here; for such a camera a
  /// request of 0 leaves the gain unchanged.
  double gain_db = 0.0;
  double exposure_us = 2000.0;
  double frame_rate_hz = 100.0;
  PixelFormat pixel_format = PixelFormat::mono8;
  Roi roi;
  /// GenICam GainRaw in the camera's own steps, for a camera without gain in dB. Other cameras
  /// report kUnknownGain. Requesting kUnknownGain leaves the raw gain unchanged.
  double gain_raw = kUnknownGain;

  friend bool same_gain(const CameraSettings& a, const CameraSettings& b) {
    return same_number(a.gain_db, b.gain_db) && same_number(a.gain_raw, b.gain_raw);
  }
  friend bool operator==(const CameraSettings& a, const CameraSettings& b) {
    return same_gain(a, b) && a.exposure_us == b.exposure_us &&
           a.frame_rate_hz == b.frame_rate_hz && a.pixel_format == b.pixel_format && a.roi == b.roi;
  }
};

template <class T>
struct Range {
  T min{}, max{}, increment{};  ///< increment: step of valid values, 0 if continuous
};

struct CameraLimits {
  Range<double> gain_db, exposure_us, frame_rate_hz;
  std::optional<Range<double>> gain_raw;  ///< only if there is no gain in dB; gain_db is unused
  Range<int> roi_width, roi_height;
  int sensor_width = 0, sensor_height = 0;
  std::vector<PixelFormat> pixel_formats;
};

struct CameraInfo {
  std::string vendor, model, serial, address;
};

/// Camera frame. The driver lends its buffer until `release`. Times in ns; mono = CLOCK_MONOTONIC.
struct GrabbedFrame {
  ImageView image;
  std::uint64_t frame_id = 0;  ///< camera's frame number, unwrapped to 64 bits: consecutive frames
                               ///< differ by 1, a duplicate repeats its number
  std::int64_t t_device_ns = 0;   ///< camera's own timestamp; 0: the camera has none
  std::int64_t t_arrival_ns = 0;  ///< frame completely received by this host, UTC since epoch
  std::int64_t t_arrival_mono_ns = 0;
  int slot = -1;                     ///< driver's buffer number, 0 .. buffer_count()-1
  bool justification_known = false;  ///< whether the driver has set image.left_justified_bits
};

enum class GrabStatus {
  frame,
  timeout,
  incomplete,
  duplicate,     ///< a frame that was already delivered; discarded
  out_of_order,  ///< a frame whose successor was already delivered; discarded
};

/// One open camera. Make device calls from the camera thread and stream calls from the acquisition
/// thread. Call `start`, `stop` and `apply` only while no stream call is in progress. Once `alive`
/// returns false, the object never recovers: destroy it and open the camera again.
class Camera {
 public:
  virtual ~Camera() = default;

  // Device calls, for the camera thread. Each may block for the device's time-out.
  virtual const CameraInfo& info() const = 0;
  virtual Result<CameraLimits> limits() = 0;
  /// Writes the camera settings that changed, reads back all settings and returns the values in
  /// use. While streaming, only gain, exposure and frame rate may change; call `stop` before
  /// changing roi or pixel_format.
  virtual Result<CameraSettings> apply(const CameraSettings& wanted) = 0;
  virtual Result<void>
  start() = 0;              ///< allocates buffers for the current payload size and starts streaming
  virtual void stop() = 0;  ///< stops streaming; release all lent frames first
  virtual bool alive() const = 0;  ///< false once control of the camera was lost. Thread-safe.

  // Stream calls, for the acquisition thread.
  virtual int buffer_count() const = 0;
  /// Waits at most `timeout` for a frame. For an unusable frame, returns its status (incomplete,
  /// duplicate, ...) and releases its buffer, so the caller must not.
  virtual GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) = 0;
  virtual void release(int slot) OVWS_NONBLOCKING = 0;
};

}  // namespace ovws
