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

/// NaN: a number that is unknown, or that a camera does not have.
inline constexpr double kUnknownGain = std::numeric_limits<double>::quiet_NaN();

/// Equal, or both not known.
inline bool same_number(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

struct CameraSettings {
  /// dB. A camera that has gain_raw instead reports kUnknownGain; requesting 0 leaves its gain
  /// alone.
  double gain_db = 0.0;
  double exposure_us = 2000.0;
  double frame_rate_hz = 100.0;
  PixelFormat pixel_format = PixelFormat::mono8;
  Roi roi;
  /// GenICam GainRaw, in the camera's own steps, of a camera without gain in dB; otherwise
  /// kUnknownGain. Requesting kUnknownGain leaves the gain unchanged.
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
  T min{}, max{}, increment{};  ///< increment 0: continuous
};

struct CameraLimits {
  Range<double> gain_db, exposure_us, frame_rate_hz;
  std::optional<Range<double>> gain_raw;  ///< camera without gain in dB: gain_db is unused
  Range<int> roi_width, roi_height;
  int sensor_width = 0, sensor_height = 0;
  std::vector<PixelFormat> pixel_formats;
};

struct CameraInfo {
  std::string vendor, model, serial, address;
};

/// A frame whose buffer the driver lends until `release`. Times in ns; mono = CLOCK_MONOTONIC.
struct GrabbedFrame {
  ImageView image;
  std::uint64_t frame_id = 0;  ///< camera's frame number, unwrapped to 64 bits: consecutive frames
                               ///< differ by 1, a duplicate repeats its number
  std::int64_t t_device_ns = 0;   ///< camera's own timestamp; 0: the camera has none
  std::int64_t t_arrival_ns = 0;  ///< frame complete in this host, UNIX epoch UTC
  std::int64_t t_arrival_mono_ns = 0;
  int slot = -1;                     ///< driver's buffer number, 0 .. buffer_count()-1
  bool justification_known = false;  ///< the driver has set image.left_justified_bits
};

enum class GrabStatus {
  frame,
  timeout,
  incomplete,
  duplicate,     ///< a frame that was already delivered; discarded
  out_of_order,  ///< a frame whose successor was already delivered; discarded
};

/// One open camera. Device calls come from one thread (the camera thread), stream calls from one
/// other (the acquisition thread). `start`, `stop` and `apply` are called only while no stream call
/// is in progress. An object whose `alive` is false never recovers: destroy it and open a new one.
class Camera {
 public:
  virtual ~Camera() = default;

  // Camera thread. May block for the device's time-out.
  virtual const CameraInfo& info() const = 0;
  virtual Result<CameraLimits> limits() = 0;
  /// Writes the settings that differ, reads all back and returns the values that the camera uses.
  /// While streaming only gain, exposure and frame rate may differ; roi and pixel_format require
  /// `stop` first.
  virtual Result<CameraSettings> apply(const CameraSettings& wanted) = 0;
  virtual Result<void>
  start() = 0;              ///< allocates buffers for the current payload size and starts streaming
  virtual void stop() = 0;  ///< all lent frames must have been released
  virtual bool alive() const = 0;  ///< false once control was lost. Thread-safe.

  // Acquisition thread.
  virtual int buffer_count() const = 0;
  /// Waits at most `timeout` for a frame. Unusable frames are released here and only reported.
  virtual GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) = 0;
  virtual void release(int slot) OVWS_NONBLOCKING = 0;
};

}  // namespace ovws
