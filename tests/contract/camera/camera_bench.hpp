/// Test bench of the camera contract: the device behind the driver under test.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/port/camera.hpp"

namespace ovws::testing {

/// A new device for every test, plugged in and idle. If a device does not support an action, the
/// default stays and the checks that need it are skipped.
class CameraBench {
 public:
  virtual ~CameraBench() = default;

  virtual Result<std::unique_ptr<Camera>> open() = 0;

  /// Settings with small frames at a high rate, suitable for all tests.
  virtual CameraSettings settings() const = 0;

  /// The gain setting that the device supports: gain_db or gain_raw.
  virtual double CameraSettings::*gain() const { return &CameraSettings::gain_db; }

  /// The device's settings, read without the driver.
  virtual std::optional<CameraSettings> truth() { return std::nullopt; }
  /// The value that the device puts at pixel (x, y) of the sensor.
  virtual std::optional<int> pixel(PixelFormat, int /*x*/, int /*y*/) const { return std::nullopt; }

  /// Makes the device lose some of its packets. False if it does not support this.
  virtual bool lose_packets() { return false; }

  // Only for rows of CameraLossContract.
  virtual void unplug() {}
  virtual void plug_in() {}
  virtual void freeze() {}
  virtual void thaw() {}
  /// Lets another program open the camera, stream, and crash.
  virtual void crash_a_client() {}
};

/// A parameter row of the suite.
struct CameraRow {
  std::string name;
  std::unique_ptr<CameraBench> (*make)();
};

}  // namespace ovws::testing
