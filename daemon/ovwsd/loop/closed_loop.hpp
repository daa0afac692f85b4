/// The closed loop: steps the integrator with each usable frame's coefficients, and shows the new
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

#include "core/control/integrator.hpp"
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
  /// Loop thread: called after the loop was closed (true) or opened (false).
  std::function<void(bool)> on_change;
  /// Loop thread: CLOCK_MONOTONIC time of the last search that found lost spots; 0: none did.
  std::function<std::int64_t()> spots_found_ns;
};

/// The agent of the loop thread. Makes one step per hologram: a frame counts only if it is valid
/// and was exposed while the newest hologram stood still. After 0.3 s without a valid frame, a
/// frame counts as well if up to a third of its spots are lost and its fit residual is small: the
/// next step corrects errors of its modes, and overlapping spots separate. The integrator's
/// patience begins again when a search finds lost spots.
class ClosedLoop : public Agent {
 public:
  using Done = std::function<void(Result<LoopReport>)>;

  explicit ClosedLoop(ClosedLoopDeps deps) : deps_(std::move(deps)) {}

  bool do_work() override;
  void on_close() override { mailbox_.close(); }

  // Thread-safe; `done` is called in the loop thread.
  /// Closes the loop, from the present correction on. Errc::refused: the loop is closed already,
  /// the sensor is not shown, there is no reference, or the correction exceeds the limit.
  /// Errc::invalid: bad settings, or a mode that is not measured.
  void close(const LoopSettings& settings, Done done);
  /// Opens the loop. Without `keep` the correction is cleared first; if that fails, nothing
  /// changes.
  void open(bool keep, Done done);
  LoopReport report() const;
  bool is_closed() const { return closed_.load(std::memory_order_relaxed); }

  /// Publish thread: offers a measured frame to the loop.
  void add(const FrameRecord& record);

 private:
  struct Sample {
    std::uint64_t hologram_id = 0;
    std::vector<int> modes_j;
    std::vector<float> residual_waves;
  };
  Result<LoopReport> begin(const LoopSettings& settings);
  Result<LoopReport> end(bool keep);
  bool take_sample();
  void act();
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
  std::int64_t valid_ns_ = 0;  ///< CLOCK_MONOTONIC, of the last valid frame; publish thread
  bool has_sample_ = false;    ///< newest_ has not been taken yet
  Guarded<LoopReport> report_;

  // The loop thread only.
  std::optional<Integrator> integrator_;
  Sample taken_;
};

}  // namespace ovws
