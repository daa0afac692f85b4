/// The SLM loop, on the main thread: presents holograms, checks the display's output, and reopens
/// the display after a fault. Each time it opens the display, it reads the shown pixels back: if
/// more than 1 % of them differ from the hologram, as behind a compositor that dims windows, that
/// is a fault.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/display.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latest_value.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/actor/time_share.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/tables/devices.hpp"

namespace ovws {

struct VerifyReport;

/// Hologram to present, with the numbers that the frame path needs.
struct HologramRequest {
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< 0: not a sensor hologram, frames are not measured
  HologramKind kind = HologramKind::sensor;
  std::shared_ptr<const Image<std::uint8_t>> levels;  ///< as for Display::present
  bool sequence = false;  ///< of a DMD's patterns, see MeasurementPlan::patterns
};

struct SlmSnapshot {
  bool healthy = false;
  std::optional<DisplayInfo> info;
  std::uint64_t hologram_id = 0;  ///< the hologram shown now; 0: none
  HologramKind kind = HologramKind::sensor;
  std::int64_t t_begin_mono_ns = 0;  ///< just before the hologram was presented
  std::int64_t t_presented_mono_ns = 0;
  std::int64_t t_settled_mono_ns = 0;
  std::int64_t t_refresh_mono_ns = 0;  ///< the display's refresh just before; 0: unknown
  std::int64_t refresh_wait_ns = 0;    ///< wait for the display's refresh before t_begin_mono_ns
  std::string fault;                   ///< why the SLM is not healthy; empty if healthy
  bool at_fault = false;  ///< a person must fix the fault before the display can be used
  SlmSettings settings;
};

struct SlmLoopDeps {
  LatestValue<ShownHologram>& shown;
  Counters& counters;
  Events& events;
  /// Called in the main thread when the SLM's health, or the reason of its fault, has changed,
  /// before its events. snapshot() waits meanwhile: other threads see the change and what this call
  /// makes of it together. It must not call snapshot().
  std::function<void(const SlmSnapshot&)> on_change;
};

class SlmLoop : public Agent {
 public:
  SlmLoop(SlmConfig config, SlmLoopDeps deps);
  ~SlmLoop() override;

  /// One turn of the main thread; waits up to 20 ms for work.
  bool do_work() override;
  /// Ends the loop; main thread, after the last turn. Pending calls of `show` and `verify` fail,
  /// later calls are refused.
  void close();

  /// Presents the hologram, and returns when the display has accepted it. It blocks, so the main
  /// thread must not call it. Fails after 2 s, and the previous hologram stays active; or on an
  /// error of the display, which is closed.
  Result<void> show(HologramRequest request);
  /// Presents the hologram as soon as a display is open, before any later `show`. Thread-safe,
  /// returns at once. A later call replaces a hologram that still waits.
  void show_when_possible(HologramRequest request);

  // `verify` and `list_outputs` keep the main thread from presenting holograms: both together have
  // a tenth of its time (TimeShare). Each answers all requests that wait for it at once.
  using VerifyDone = std::function<void(const Result<VerifyReport>&)>;
  /// Reads back the display's buffer and compares it with the hologram presented last. Thread-safe;
  /// `done` is called in the main thread (after close: in the caller's). A difference is also
  /// reported as an event. Errors: there is no display or no hologram, or the display system does
  /// not allow reading.
  void verify(const VerifyDone& done);
  using OutputsDone = std::function<void(const Result<std::vector<DisplayOutput>>&)>;
  /// Lists the outputs of the display system. Thread-safe; `done` is called in the main thread
  /// (after close: in the caller's).
  void list_outputs(const OutputsDone& done);
  using SettingsDone = std::function<void(Result<SlmSettings>)>;
  /// Changes the settings, all or nothing, and reopens the display if it is another output.
  /// Thread-safe; `done` gets the settings in use, in the main thread (after close: in the
  /// caller's). Errors: the output cannot be used; the former settings stay in use.
  void change(SlmSet change, const SettingsDone& done);

  SlmSnapshot snapshot() const { return snapshot_.get(); }

 private:
  /// A call of `show`; its caller may have stopped waiting.
  struct Job {
    HologramRequest request;
    std::promise<Result<void>> done;
    bool abandoned = false;  ///< guarded by mutex_
  };
  /// A call of `change`.
  struct Change {
    SlmSet change;
    SettingsDone done;
  };
  struct Pending {
    std::optional<HologramRequest> when_possible;
    std::shared_ptr<Job> job;
    std::vector<VerifyDone> verify;
    std::vector<OutputsDone> outputs;
    std::vector<Change> changes;
  };

  template <class Request>
  bool add(std::vector<Request> Pending::*queue, Request request);
  Pending wait_for_work();
  void inspect(const Pending& asked);
  void carry_out(Job& job);
  Result<VerifyReport> compare_output();
  Result<SlmSettings> use(const Change& asked);
  Result<void> reopen(const SlmConfig& config);
  void try_open();
  Result<void> check_levels(const Image<std::uint8_t>& levels);
  Result<void> present(const HologramRequest& request);
  void fault(const Error& why);
  void publish_snapshot(const std::optional<Error>& why);

  SlmConfig config_;
  SlmLoopDeps deps_;
  std::unique_ptr<Display> display_;
  std::optional<HologramRequest> requested_;
  ShownHologram shown_;
  std::int64_t t_presented_mono_ns_ = 0;
  std::int64_t t_refresh_mono_ns_ = 0, refresh_wait_ns_ = 0;
  std::int64_t next_try_ns_ = 0;
  std::int64_t next_check_ns_ = 0;
  TimeShare inspections_;  ///< of verify and list_outputs
  Guarded<SlmSnapshot> snapshot_;

  std::mutex mutex_;
  std::condition_variable ready_;
  Pending pending_;
  bool closed_ = false;
};

}  // namespace ovws
