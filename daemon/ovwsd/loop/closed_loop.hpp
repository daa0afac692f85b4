/// The closed loop: gives the control laws each usable frame's coefficients, and shows the new
/// correction on the SLM.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/control/loop_watch.hpp"
#include "core/control/modal_control.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/tables/loop.hpp"

namespace ovws {

struct ClosedLoopDeps {
  SensorKeeper& keeper;
  Events& events;
  /// Called in the loop thread after the loop was closed (true) or opened (false).
  std::function<void(bool)> on_change;
  /// CLOCK_MONOTONIC time (ns) of the last search that found lost spots; 0: there was none. Called
  /// in the loop thread.
  std::function<std::int64_t()> spots_found_ns;
};

/// Closed-loop control in the loop thread: one step per hologram. A step uses a valid frame that
/// was exposed while the newest hologram stood still. After 0.3 s without a valid frame, a step
/// also uses a frame with a small fit residual and up to a third of its spots lost. The correction
/// then separates overlapping spots, so that frames can become valid again. The patience begins
/// again when a search finds lost spots.
class ClosedLoop : public Agent {
 public:
  using Done = std::function<void(Result<LoopReport>)>;

  explicit ClosedLoop(ClosedLoopDeps deps) : deps_(std::move(deps)) {}

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

  // Thread-safe methods; `done` is called in the loop thread.
  /// Closes the loop, starting from the present correction. Errc::refused: the loop is already
  /// closed, the sensor's hologram is not shown, there is no reference, or the correction exceeds
  /// the limit. Errc::invalid: invalid settings, or a mode that is not measured.
  void close(const LoopSettings& settings, Done done);
  /// Opens the loop. With `keep`, the correction stays on the SLM; otherwise it is cleared first.
  /// If clearing fails, the loop stays as it was.
  void open(bool keep, Done done);
  LoopReport report() const;
  bool is_closed() const { return closed_.load(std::memory_order_relaxed); }

  /// Offers a measured frame to the loop; called by the publish thread.
  void add(const FrameRecord& record);

 private:
  struct Sample {
    std::uint64_t hologram_id = 0;
    std::vector<int> modes_j;
    std::vector<float> residual_waves, sigma_waves;
    std::int64_t t_ns = 0;  ///< about the middle of the exposure, CLOCK_MONOTONIC
  };
  Result<LoopReport> begin(const LoopSettings& settings);
  Result<LoopReport> end(bool keep);
  SensorView take_sample();
  void act(const SensorSnapshot& sensor);
  Result<void> show(const std::vector<Mode>& correction);
  Result<SensorView> hold(const LoopSettings& settings);
  Result<SensorView> ask(const std::function<void(SensorKeeper::Done)>& what);
  void set_closed(bool closed, const std::string& why, Severity severity);
  void report_step();

  ClosedLoopDeps deps_;
  Mailbox mailbox_;
  std::atomic<bool> closed_{false};
  std::mutex mutex_;
  std::condition_variable filled_;
  Sample newest_;
  std::int64_t valid_ns_ = 0;  ///< CLOCK_MONOTONIC of the last valid frame; publish thread only
  bool has_sample_ = false;    ///< newest_ has not been taken yet
  Guarded<LoopReport> report_;

  // Used by the loop thread only.
  std::optional<ModalControl> control_;
  std::optional<LoopWatch> watch_;
  Sample taken_;
};

}  // namespace ovws
