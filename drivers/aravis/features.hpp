/// The settings and limits of the camera port as GenICam features, old and new names alike.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/aravis/genicam_device.hpp"
#include "drivers/aravis/settings_check.hpp"

namespace ovws {

/// Names the setting at fault, where the device only knows the feature.
template <class T>
Result<T> at_field(const char* field, Result<T> result) {
  if (!result) result.error().field = field;
  return result;
}

/// Camera thread only. The device must outlive it. A camera that has its gain only as GainRaw has
/// it in steps of its own, gain_raw: what these are in dB is not known.
class CameraFeatures {
 public:
  /// Finds the names that this camera uses. Errc::device, naming the feature, if it has none of
  /// them.
  static Result<CameraFeatures> find(GenicamDevice& device);

  /// Free running, all automatic functions off, pixel format one of ours.
  Result<void> prepare();
  CameraInfo info(const std::string& address);
  Result<CameraLimits> limits();
  Result<CameraSettings> read();

  /// Brings the camera from `current` to `wanted`, and reads back. All or nothing: after an error
  /// the camera has `current` again, unless it does not answer any more or was reset meanwhile:
  /// then the device is not `alive` any more.
  Result<CameraSettings> apply(const CameraSettings& wanted, const CameraSettings& current,
                               bool streaming);

 private:
  explicit CameraFeatures(GenicamDevice& device) : device_(&device) {}
  using Undo = std::vector<std::function<void()>>;

  Result<void> turn_triggers_off();
  Result<void> choose_a_known_pixel_format();
  Result<int> sensor_extent(const char* sensor, const char* extent, const char* offset);
  Result<RoiSteps> roi_steps();
  Result<CameraSettings> fit(const CameraSettings& wanted, const CameraSettings& current);
  Result<CameraSettings> write_and_read(const CameraSettings& wanted, const CameraSettings& current,
                                        Undo& undo);
  Result<void> write(const CameraSettings& wanted, const CameraSettings& current, Undo& undo);
  Result<void> fit_gain(const CameraSettings& current, const CameraLimits& limits,
                        CameraSettings& settings) const;
  Result<void> write_roi(const Roi& roi);
  Result<void> write_exposure(const CameraSettings& wanted, const CameraSettings& current,
                              Undo& undo);
  Result<void> write_rate(const CameraSettings& wanted, const CameraSettings& current, Undo& undo);

  GenicamDevice* device_;
  /// The gain of such settings in the camera's own unit.
  double& gain_of(CameraSettings& settings) const {
    return gain_is_raw_ ? settings.gain_raw : settings.gain_db;
  }
  double gain_of(const CameraSettings& settings) const {
    return gain_is_raw_ ? settings.gain_raw : settings.gain_db;
  }
  const char* gain_field() const { return gain_is_raw_ ? "camera.gain_raw" : "camera.gain_db"; }

  const char* gain_ = nullptr;
  bool gain_is_raw_ = false;
  const char* exposure_ = nullptr;
  const char* rate_ = nullptr;
  const char* sensor_width_ = nullptr;
  const char* sensor_height_ = nullptr;
};

}  // namespace ovws
