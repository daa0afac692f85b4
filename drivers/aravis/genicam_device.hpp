/// One controlled device and its GenICam features by name; knows when the device is gone.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/port/camera.hpp"
#include "drivers/aravis/gerror.hpp"

namespace ovws {

inline constexpr const char* kCameraWasReset =
    "the camera was reset (it lost power, or another program reset it) and has forgotten its "
    "settings";

/// Owned and used by the camera thread. A call on a camera that does not answer takes up to 5 s
/// (2.5 s of Aravis's retries, and as long again if its heartbeat is just waiting too); after one
/// such call `alive` is false and every further call fails at once. Errors are Errc::device, with
/// an empty field.
class GenicamDevice {
 public:
  explicit GenicamDevice(GRef<ArvDevice> device);
  ~GenicamDevice();
  GenicamDevice(const GenicamDevice&) = delete;
  GenicamDevice& operator=(const GenicamDevice&) = delete;

  bool alive() const { return alive_.load(std::memory_order_relaxed); }  ///< thread-safe
  /// From now on every call fails: what the camera uses is not known any more.
  void give_up() { alive_.store(false, std::memory_order_relaxed); }
  /// Reads from a GigE camera who controls it: one that lost power has forgotten this program, yet
  /// may answer as if nothing had happened. Then Errc::device, and `alive` is false.
  Result<void> check_control();
  bool is_gige() const { return ARV_IS_GV_DEVICE(device_.get()); }
  ArvDevice* raw() { return device_.get(); }

  bool has(const char* feature);
  bool has_number(const char* feature);  ///< there is such a feature, and it is a float or integer

  /// Floats and integers alike; an integer is set to the nearest.
  Result<double> number(const char* feature);
  Result<Range<double>> range(const char* feature);
  Result<void> set_number(const char* feature, double value);

  /// Strings and enumerations.
  Result<std::string> text(const char* feature);
  Result<std::vector<std::string>> choices(const char* feature);
  Result<void> set_text(const char* feature, const char* value);

  /// Nothing to do, and no error, where the camera has no such feature or choice.
  Result<void> choose_if_offered(const char* feature, const char* choice);
  Result<void> switch_if_there(const char* feature, bool on);

  Result<void> execute(const char* command);

 private:
  template <class Call>
  auto ask(const char* verb, const char* feature, Call call)
      -> Result<decltype(call(static_cast<GError**>(nullptr)))>;

  // Outlives the device, whose own thread writes it.
  std::atomic<bool> alive_{true};
  GRef<ArvDevice> device_;
  gulong control_lost_ = 0;
};

}  // namespace ovws
