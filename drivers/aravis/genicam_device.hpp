/// GenICam device under our control: access to features by name, and detection of a lost device.
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

/// GenICam device, owned and used by the camera thread. A call on a camera that does not answer
/// takes up to 5 s: 2.5 s of Aravis's retries, and 2.5 s more if its heartbeat waits at that time.
/// After a call without an answer `alive` is false and further calls fail at once. Errors are
/// Errc::device with an empty field.
class GenicamDevice {
 public:
  explicit GenicamDevice(GRef<ArvDevice> device);
  ~GenicamDevice();
  GenicamDevice(const GenicamDevice&) = delete;
  GenicamDevice& operator=(const GenicamDevice&) = delete;

  bool alive() const { return alive_.load(std::memory_order_relaxed); }  ///< thread-safe
  /// Marks the device as lost, so that further calls fail: its settings are no longer known.
  void give_up() { alive_.store(false, std::memory_order_relaxed); }
  /// Checks that this program still controls a GigE camera, by its privilege register. A camera
  /// that lost power may answer again but has no controller: Errc::device, and `alive` is false.
  Result<void> check_control();
  bool is_gige() const { return ARV_IS_GV_DEVICE(device_.get()); }
  ArvDevice* raw() { return device_.get(); }

  bool has(const char* feature);
  bool has_number(const char* feature);  ///< an available float or integer feature

  /// Access to float and integer features. An integer feature is set to the nearest integer.
  Result<double> number(const char* feature);
  Result<Range<double>> range(const char* feature);
  Result<void> set_number(const char* feature, double value);

  /// Access to string and enumeration features.
  Result<std::string> text(const char* feature);
  Result<std::vector<std::string>> choices(const char* feature);
  Result<void> set_text(const char* feature, const char* value);

  /// Sets an optional feature. Does nothing, without an error, if the camera lacks the feature or
  /// the choice.
  Result<void> choose_if_offered(const char* feature, const char* choice);
  Result<void> switch_if_offered(const char* feature, bool on);

  Result<void> execute(const char* command);

 private:
  template <class Call>
  auto ask(const char* verb, const char* feature, Call call)
      -> Result<decltype(call(static_cast<GError**>(nullptr)))>;

  // alive_ is declared first so that it outlives the device: Aravis's thread writes alive_.
  std::atomic<bool> alive_{true};
  GRef<ArvDevice> device_;
  gulong control_lost_ = 0;
};

}  // namespace ovws
