/// The camera actor: opens the camera, applies settings, supervises the frame stream, and
/// reconnects when frames stop.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/config.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/latest_value.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Copy of the camera's state for other threads.
struct CameraSnapshot {
  bool connected = false;
  std::optional<CameraInfo> info;
  CameraSettings settings;  ///< as read back; as requested while disconnected
  CameraSettings asked;     ///< as requested; `settings` may differ by rounding
  std::optional<CameraLimits> limits;
  std::string fault;       ///< why the camera is not connected; empty if connected
  bool at_fault = false;   ///< the camera is present, but unusable until a person fixes the fault
  std::string id;          ///< camera.id in use
  bool triggered = false;  ///< pulses start the exposures: their rate is not known
  std::int64_t settings_since_ns = 0;  ///< start of the stream or last write, CLOCK_MONOTONIC

  /// Frame rate that the camera should have reached since `begin_mono_ns`. None if it is not
  /// connected, is triggered, or had other settings meanwhile.
  std::optional<double> expected_hz(std::int64_t begin_mono_ns) const {
    if (!connected || triggered || settings_since_ns > begin_mono_ns) return std::nullopt;
    return settings.frame_rate_hz;
  }

  /// What undoes `change` of exposure and gain after the changes that `undo` undoes: the values as
  /// requested, or as read back where nothing was requested.
  CameraSet undo_of(const CameraSet& change, CameraSet undo = {}) const;
};

struct CameraActorDeps {
  Pipeline& pipeline;
  LatestValue<AppliedSettings>& settings;
  Counters& counters;
  Events& events;
  /// Called in the camera thread at each change of settings, connection or fault, before its
  /// events. New settings may change the image's size or format. snapshot() waits meanwhile: other
  /// threads see the change and what this call makes of it together. It must not call snapshot().
  std::function<void(const CameraSnapshot&)> on_change;
};

/// Agent of the camera thread: owns the camera.
class CameraActor : public Agent {
 public:
  using Applied = std::function<void(Result<CameraSnapshot>)>;

  CameraActor(CameraConfig config, CameraActorDeps deps);
  ~CameraActor() override;

  bool do_work() override;
  void on_close() override;

  /// Applies the change in the camera thread, and calls `done` there with the settings in use
  /// afterwards. A camera at fault is reopened with the change. Without a camera, or for a gain in
  /// dB that the camera does not have, `done` gets the error at once in the caller's thread.
  /// Thread-safe.
  void change(CameraSet change, Applied done);
  /// Applies a change as `change` does, or keeps it for the next connection of a camera.
  void change_or_keep(CameraSet change, Applied done);
  /// Disconnects the camera and connects to the one with this id, with `change` applied to the
  /// requested settings. `done` gets the state afterwards, which is without a camera if that one
  /// cannot use the settings, or with `wait` if it does not answer; the change is then kept for the
  /// next connection. Otherwise, if it cannot be opened, the former camera is opened again with the
  /// former settings and `done` gets the error. Thread-safe.
  void select(std::string id, CameraSet change, bool wait, Applied done);
  /// Restores the settings of `before`, now or at the next connection. `then` is called
  /// in the camera thread, or destroyed uncalled if that thread has ended. Thread-safe.
  void restore(CameraSet before, std::function<void()> then);
  CameraSnapshot snapshot() const { return snapshot_.get(); }

 private:
  using UnusableFrames = std::array<std::uint64_t, 3>;  ///< counts in the order of kUnusable

  void carry_out(const CameraSet& change, const Applied& done);
  void carry_out_selection(const std::string& id, const CameraSet& change, bool wait,
                           const Applied& done);
  void keep_for_next(const CameraSet& change);
  void reopen(const CameraSet& change, const Applied& done);
  void open_with(const CameraSet& change);
  void keep_asked(const CameraSet& change);
  Result<void> start_stream(const CameraSettings& wanted);
  void lose(const Error& why);
  bool close_camera();
  void destroy_camera();
  void refresh_limits();
  double silent_s(std::int64_t last_ns) const;
  double frame_timeout_s() const;
  void watch_frames();
  UnusableFrames count_unusable() const;
  bool report_unusable();
  Result<CameraSettings> apply(const CameraSettings& wanted);
  Result<CameraSettings> apply_live(const CameraSettings& wanted);
  Result<CameraSettings> apply_stopped(const CameraSettings& wanted);
  void write_applied_settings(const CameraSettings& before, const CameraSettings& after,
                              std::int64_t t_begin_ns, std::int64_t t_end_ns);
  void publish_connected();
  void publish_absent(const Error& why);
  void publish(CameraSnapshot now);

  CameraConfig config_;
  CameraActorDeps deps_;
  Mailbox mailbox_;
  std::unique_ptr<Camera> camera_;
  bool lost_ = false;        ///< camera_ is destroyed as soon as the frame path releases its frames
  CameraSettings settings_;  ///< last read back; applied again after a reconnection
  CameraSettings asked_;     ///< the request that settings_ result from
  std::int64_t settings_since_ns_ = 0;     ///< time at which settings_ had been written
  double previous_frame_timeout_s_ = 0.0;  ///< frame_timeout_s with the previous settings
  std::optional<CameraLimits> limits_;
  std::int64_t next_try_ns_ = 0;
  std::int64_t attached_ns_ = 0;
  bool ever_connected_ = false;
  std::int64_t last_frame_ns_ = 0;    ///< time of the last usable frame seen
  UnusableFrames unusable_before_{};  ///< counts at the last usable frame
  bool unusable_reported_ = false;    ///< an event has reported that all frames are unusable
  Guarded<CameraSnapshot> snapshot_;
};

}  // namespace ovws
