/// GenICam features for the settings and limits of the camera port, with SFNC and older names.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/aravis/genicam_device.hpp"
#include "drivers/aravis/settings_check.hpp"

namespace ovws {

/// Sets an error's field to the setting that caused it, because the device reports only the
/// feature.
template <class T>
Result<T> at_field(const char* field, Result<T> result) {
  if (!result) result.error().field = field;
  return result;
}

/// Camera features by name. Camera thread only. The device must outlive this object. A camera that
/// offers only GainRaw has its gain in gain_raw: device-specific steps of unknown size in dB.
class CameraFeatures {
 public:
  /// Finds the feature names that this camera uses. Errc::device, naming the feature, if a required
  /// feature is missing.
  static Result<CameraFeatures> find(GenicamDevice& device);

  /// Configures continuous acquisition: all automatic functions off, a supported pixel format, and
  /// each frame started by `trigger`, a TriggerSource; empty: free running. Errors: field
  /// camera.trigger, the camera has no such trigger.
  Result<void> prepare(const std::string& trigger);
  CameraInfo info(const std::string& address);
  Result<CameraLimits> limits();
  Result<CameraSettings> read();

  /// Changes the camera's settings from `current` to `wanted` and reads them back. After an error,
  /// `current` is restored. If this fails, or the camera stopped answering or was reset, the device
  /// is no longer `alive`.
  Result<CameraSettings> apply(const CameraSettings& wanted, const CameraSettings& current,
                               bool streaming);

 private:
  explicit CameraFeatures(GenicamDevice& device) : device_(&device) {}
  using Undo = std::vector<std::function<void()>>;

  Result<void> turn_triggers_off();
  Result<void> use_trigger(const std::string& source);
  Result<void> choose_supported_pixel_format();
  Result<int> sensor_extent(const char* sensor, const char* extent, const char* offset);
  Result<RoiSteps> roi_steps();
  Result<CameraSettings> fit(const CameraSettings& wanted, const CameraSettings& current);
  Result<CameraSettings> write_and_read(const CameraSettings& wanted, const CameraSettings& current,
                                        Undo& undo);
  Result<void> write(const CameraSettings& wanted, const CameraSettings& current, Undo& undo);
  Result<void> fit_gain(const CameraSettings& current, const CameraLimits& limits,
                        CameraSettings& settings) const;
  Result<void> write_roi(const Roi& roi);

  /// Numeric setting, and the GenICam feature in which this camera has it.
  struct Number {
    const char* field;  ///< name of the setting in errors: "camera.gain_db"
    const char* what;   ///< name in messages: "a gain"
    double CameraSettings::*value;
    const char* feature = nullptr;
  };
  Result<void> write_time(const Number& number, const CameraSettings& wanted,
                          const CameraSettings& current, Undo& undo);
  bool gain_is_raw() const { return gain_.value == &CameraSettings::gain_raw; }

  GenicamDevice* device_;
  Number gain_{"camera.gain_db", "a gain", &CameraSettings::gain_db};  ///< or gain_raw
  Number exposure_{"camera.exposure_us", "an exposure", &CameraSettings::exposure_us};
  Number rate_{"camera.frame_rate_hz", "a frame rate", &CameraSettings::frame_rate_hz};
  const char* sensor_width_ = nullptr;
  const char* sensor_height_ = nullptr;
};

}  // namespace ovws
