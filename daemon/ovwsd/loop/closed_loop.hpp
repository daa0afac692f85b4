/// The closed loop: gives the control laws each usable frame's coefficients, and shows the new
/// correction on the SLM.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/control/loop_model.hpp"
#include "core/control/loop_watch.hpp"
#include "core/control/modal_control.hpp"
#include "core/control/step_times.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/loop/loop_log.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/tables/loop.hpp"

namespace ovws {

struct ClosedLoopDeps {
  FrameTaps& frames;
  SensorKeeper& keeper;
  Leases& leases;
  const SlmLoop& slm;
  Events& events;
  /// CLOCK_MONOTONIC time (ns) of the last search that found lost spots; 0: there was none. Called
  /// in the loop thread.
  std::function<std::int64_t()> spots_found_ns;
  /// Why frames are not valid, and what to do; empty: they are, or the camera sends none. Called in
  /// the loop thread.
  std::function<std::string()> why_invalid;
  /// Adds a document to the recording, if there is one. Called in the loop thread.
  LoopLog::Write record;
};

/// Closed-loop control in the loop thread. The control laws observe every valid frame with the
/// correction of its hologram. A step uses the frames that have come since the last step, and is
/// taken when t_due_ns says so, for which a frame of the newest hologram need not have arrived.
/// After 0.3 s without a valid frame, a frame with a small fit residual and up to a third of its
/// spots lost serves, too. The correction then separates overlapping spots, so that frames can
/// become valid again. The patience begins again when a search finds lost spots, and does not count
/// while the camera or the display is not connected: the loop then holds its correction.
class ClosedLoop : public Agent {
 public:
  using Done = std::function<void(Result<LoopReport>)>;

  explicit ClosedLoop(ClosedLoopDeps deps) : deps_(std::move(deps)), log_(deps_.record) {}
  ~ClosedLoop() override;

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

  // Thread-safe methods, carried out in the order of the calls; `done` is called in the loop
  // thread, a refusal of `close` in any.
  /// Closes the loop, starting from the present correction; it has `lease`, that of close_loop,
  /// until it opens. Errc::refused: the sensor's hologram is not shown, there is no reference, or
  /// the correction exceeds the limit; field "law": the law needs a model that loop.identify has
  /// not made. Errc::invalid: invalid settings, or a mode that is not measured.
  void close(LeasePtr lease, const LoopSettings& settings, Done done);
  /// Opens the loop. With `keep`, the correction stays on the SLM; otherwise it is cleared first.
  /// If clearing fails, the loop stays as it was.
  void open(bool keep, Done done);
  /// Holds the correction, or goes on. Errc::refused: the loop is open.
  void pause(bool paused, Done done);
  LoopReport report() const;
  /// Model for the laws of loops that are closed from now on; null: none was identified.
  std::shared_ptr<const LoopModel> model() const { return model_.get(); }
  void use_model(LoopModel model) {
    model_.set(std::make_shared<const LoopModel>(std::move(model)));
  }
  bool is_closed() const { return closed_.load(std::memory_order_relaxed); }
  bool is_paused() const { return paused_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kFrames = 64;  ///< that may wait; more are dropped
  /// Keeps `open` and `pause` behind each `close` that was requested before.
  struct Order {
    std::mutex mutex;
    int closing = 0;                               ///< requests that have not ended
    std::vector<std::function<void()>> waiting{};  ///< for them
    bool is_over = false;                          ///< the loop was destroyed
  };
  std::shared_ptr<void> closing();
  void post_after_closing(std::function<void()> task);
  LoopReport begin(const LeasePtr& lease, const LoopSettings& settings,
                   const std::shared_ptr<const LoopModel>& known, const SensorSnapshot& sensor);
  Result<LoopReport> end(bool keep);
  Result<LoopReport> set_paused(bool paused);
  void notice_bench();
  bool observe_next();
  std::int64_t t_step_due_ns() const;
  bool is_usable(const FrameRecord& record) OVWS_NONBLOCKING;
  void observe(const FrameCopy& frame);
  void step(const FrameCopy& frame);
  void add_times(const FrameCopy& frame, std::int64_t decided_ns, const SlmSnapshot& before);
  Result<void> show(const std::vector<Mode>& correction);
  void open_because(LoopEnd end);
  std::string why_no_frame() const;
  Result<SensorView> checked(const LoopSettings& settings, const LoopModel* model) const;
  void set_closed(bool closed, const std::string& why, Severity severity);
  void report_step();

  ClosedLoopDeps deps_;
  Mailbox mailbox_;
  std::atomic<bool> closed_{false}, paused_{false};
  std::int64_t valid_ns_ = 0;  ///< CLOCK_MONOTONIC of the last valid frame; see is_usable
  std::shared_ptr<Order> order_ = std::make_shared<Order>();
  Guarded<std::shared_ptr<const LoopModel>> model_;
  Guarded<LoopReport> report_;

  // Used by the loop thread only.
  LeasePtr lease_;  ///< while the loop is closed
  std::optional<ModalControl> control_;
  std::optional<LoopWatch> watch_;
  LoopLog log_;
  StepLog times_;
  FrameCopy taken_;                  ///< the last frame that was observed
  bool stepped_ = true;              ///< a step has used it
  bool away_ = false;                ///< the camera or the display is not connected
  std::uint64_t shown_id_ = 0;       ///< the hologram that the last step showed
  std::int64_t t_observed_ns_ = 0;   ///< when `taken_` was observed
  RecentTime lead_;                  ///< from a decision to the middle of its hologram's time
  RecentTime prepare_;               ///< from a decision to the wait for the refresh
  std::optional<FrameFeed> frames_;  ///< usable frames, while the loop is closed
};

}  // namespace ovws
