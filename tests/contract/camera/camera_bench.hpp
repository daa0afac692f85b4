/// What the camera contract needs besides the driver under test: the device on the other side.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/port/camera.hpp"

namespace ovws::testing {

/// One device of its own for every test, plugged in and idle at first. A driver whose device cannot
/// do a thing leaves the default, and what would check it is skipped.
class CameraBench {
 public:
  virtual ~CameraBench() = default;

  virtual Result<std::unique_ptr<Camera>> open() = 0;

  /// Small frames at a fast rate that every one of the tests can stream.
  virtual CameraSettings settings() const = 0;

  /// The unit that the device has its gain in.
  virtual double CameraSettings::*gain() const { return &CameraSettings::gain_db; }

  /// What the device has, asked past the driver.
  virtual std::optional<CameraSettings> truth() { return std::nullopt; }
  /// The pixel that the device puts at x, y of the sensor.
  virtual std::optional<int> pixel(PixelFormat, int /*x*/, int /*y*/) const { return std::nullopt; }

  /// From now on the device loses some of its packets. False: this device cannot.
  virtual bool lose_packets() { return false; }

  // Only for rows of CameraLossContract.
  virtual void unplug() {}
  virtual void plug_in() {}
  virtual void freeze() {}
  virtual void thaw() {}
  /// Another program opens the camera, streams, and ends without a word.
  virtual void crash_a_client() {}
};

/// A row of the suite.
struct CameraRow {
  std::string name;
  std::unique_ptr<CameraBench> (*make)();
};

}  // namespace ovws::testing
