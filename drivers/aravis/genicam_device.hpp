/// One controlled device: access to GenICam features by name, and detection of its loss.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/aravis/gerror.hpp"

namespace ovws {

inline constexpr const char* kCameraWasReset =
    "the camera was reset (it lost power, or another program reset it) and has lost its settings; "
    "it will be connected again";

/// Owned and used by the camera thread. A call on a camera that does not answer takes up to 5 s
/// (2.5 s of Aravis's retries, and as long again if its heartbeat is waiting at the same time).
/// After one such call `alive` is false and further calls fail at once. Errors are Errc::device
/// with an empty field.
class GenicamDevice {
 public:
  explicit GenicamDevice(GRef<ArvDevice> device);
  ~GenicamDevice();
  GenicamDevice(const GenicamDevice&) = delete;
  GenicamDevice& operator=(const GenicamDevice&) = delete;

  bool alive() const { return alive_.load(std::memory_order_relaxed); }  ///< thread-safe
  /// Makes every further call fail, because the camera's settings are no longer known.
  void give_up() { alive_.store(false, std::memory_order_relaxed); }
  /// Reads the control privilege of a GigE camera. A camera that lost power has dropped our control
  /// but may still answer; then Errc::device, and `alive` is false.
  Result<void> check_control();
  bool is_gige() const { return ARV_IS_GV_DEVICE(device_.get()); }
  ArvDevice* raw() { return device_.get(); }

  bool has(const char* feature);
  bool has_number(const char* feature);  ///< an available float or integer feature

  /// Float and integer features; an integer is set to the nearest value.
  Result<double> number(const char* feature);
  Result<Range<double>> range(const char* feature);
  Result<void> set_number(const char* feature, double value);

  /// String and enumeration features.
  Result<std::string> text(const char* feature);
  Result<std::vector<std::string>> choices(const char* feature);
  Result<void> set_text(const char* feature, const char* value);

  /// No-ops without an error if the camera has no such feature or choice.
  Result<void> choose_if_offered(const char* feature, const char* choice);
  Result<void> switch_if_offered(const char* feature, bool on);

  Result<void> execute(const char* command);

 private:
  template <class Call>
  auto ask(const char* verb, const char* feature, Call call)
      -> Result<decltype(call(static_cast<GError**>(nullptr)))>;

  // Declared first to outlive the device, whose own thread writes it.
  std::atomic<bool> alive_{true};
  GRef<ArvDevice> device_;
  gulong control_lost_ = 0;
};

}  // namespace ovws
