/// The camera's keeper: opens it, applies settings, watches that frames flow, and opens it anew
/// when they do not.
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

/// What others may know of the camera at any time.
struct CameraSnapshot {
  bool connected = false;
  std::optional<CameraInfo> info;
  CameraSettings settings;  ///< as read back; while not connected, as wanted
  CameraSettings asked;     ///< what the camera made `settings` of: it may round
  std::optional<CameraLimits> limits;
  std::string fault;      ///< why it is not connected; empty if it is
  bool at_fault = false;  ///< it is there, and cannot be used until somebody mends that
};

struct CameraActorDeps {
  Pipeline& pipeline;
  LatestValue<AppliedSettings>& settings;
  Counters& counters;
  Events& events;
  /// Whether settings may be changed now; asked in the camera thread, when a change is carried out.
  std::function<Result<void>()> may_change;
  /// Called in the camera thread after the image's size or format may have changed, and when the
  /// camera came or went.
  std::function<void(const CameraSnapshot&)> on_change;
};

/// An agent of the camera thread.
class CameraActor : public Agent {
 public:
  using Applied = std::function<void(Result<CameraSnapshot>)>;

  CameraActor(CameraConfig config, CameraActorDeps deps);
  ~CameraActor() override;

  bool do_work() override;
  void on_close() override;

  /// Thread-safe: carried out in the camera thread, `done` is called there with what the camera
  /// uses now. A camera at fault is tried anew with the change. Without a camera `done` is called
  /// at once, in the caller's thread.
  void change(CameraSet change, Applied done);
  /// The same for the job that runs, which does not ask whether it may.
  void change_for_job(CameraSet change, Applied done);
  /// As `change`; while no camera is connected, this is what the next connection asks for.
  void change_or_want(CameraSet change, Applied done);
  /// Thread-safe: `gain_db` again after a job, now or, if no camera is connected, when one is.
  /// `then` is called in the camera thread, or destroyed if that has ended.
  void put_back_gain(double gain_db, std::function<void()> then);
  CameraSnapshot snapshot() const { return snapshot_.get(); }

 private:
  using UselessFrames = std::array<std::uint64_t, 3>;  ///< by why

  void carry_out(const CameraSet& change, const Applied& done);
  void mend(const CameraSet& change, const Applied& done);
  void open_with(const CameraSet& change);
  void keep_asked(const CameraSet& change);
  Result<void> start_stream(const CameraSettings& wanted);
  void lose(const Error& why);
  bool give_up_camera();
  void refresh_limits();
  double silent_s(std::int64_t last_ns) const;
  double patience_s() const;
  void watch_frames();
  UselessFrames count_useless() const;
  bool tell_useless();
  Result<CameraSettings> apply(const CameraSettings& wanted);
  Result<CameraSettings> apply_live(const CameraSettings& wanted);
  Result<CameraSettings> apply_stopped(const CameraSettings& wanted);
  void tell_frame_path(const CameraSettings& before, const CameraSettings& after,
                       std::int64_t t_begin_ns, std::int64_t t_end_ns);
  void publish_connected();
  void publish_absent(const Error& why);
  void publish(CameraSnapshot now);

  CameraConfig config_;
  CameraActorDeps deps_;
  Mailbox mailbox_;
  std::unique_ptr<Camera> camera_;
  bool lost_ = false;  ///< camera_ is to be given up as soon as the frame path has let go of it
  CameraSettings settings_;             ///< last verified; wanted again after a reconnection
  CameraSettings asked_;                ///< what they came of
  std::int64_t settings_since_ns_ = 0;  ///< when the write of settings_ had ended
  double patience_before_s_ = 0.0;      ///< with a silent camera, by the settings before those
  std::optional<CameraLimits> limits_;
  std::int64_t next_try_ns_ = 0;
  std::int64_t attached_ns_ = 0;
  bool ever_connected_ = false;
  std::int64_t last_frame_ns_ = 0;  ///< that could be used, as last seen
  UselessFrames useless_before_{};  ///< counted until then
  bool useless_told_ = false;       ///< frames arrive, and none that can be used
  Guarded<CameraSnapshot> snapshot_;
};

}  // namespace ovws
