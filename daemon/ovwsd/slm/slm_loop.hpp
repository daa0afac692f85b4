/// The SLM loop, on the main thread: presents holograms, checks the display's output, and reopens
/// the display after a fault.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/display.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latest_value.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

/// A hologram to present, with what the frame path must know of it.
struct HologramRequest {
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< 0: not a sensor hologram, nothing to measure
  HologramKind kind = HologramKind::sensor;
  std::shared_ptr<const Image<std::uint8_t>> grey;
};

struct SlmSnapshot {
  bool healthy = false;
  std::optional<DisplayInfo> info;
  std::uint64_t hologram_id = 0;  ///< shown now; 0: none
  HologramKind kind = HologramKind::sensor;
  std::int64_t t_presented_mono_ns = 0;
  std::int64_t t_settled_mono_ns = 0;
  std::string fault;      ///< why it is not healthy; empty if it is
  bool at_fault = false;  ///< it is present, but cannot be used until a person fixes the fault
};

/// Comparison of the display's buffer, read back, with the hologram presented.
struct SlmVerdict {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0;        ///< of the grey levels presented, row by row
  std::uint32_t crc32_shown = 0;  ///< of the grey levels read back
  int differing_pixels = 0;
};

struct SlmLoopDeps {
  LatestValue<ShownHologram>& shown;
  Counters& counters;
  Events& events;
  /// Main thread: health, or why it is not healthy, changed.
  std::function<void(const SlmSnapshot&)> on_change;
};

class SlmLoop : public Agent {
 public:
  SlmLoop(SlmConfig config, SlmLoopDeps deps);
  ~SlmLoop() override;

  /// Main thread: one turn; waits 20 ms at most for work.
  bool do_work() override;
  /// Main thread, after the last turn: pending calls of `show` and `verify` fail, later ones are
  /// refused.
  void close();

  /// Any thread but the main one: presents the hologram, and returns when the display has accepted
  /// it. Fails after 2 s; the previous hologram then remains the one to show.
  Result<void> show(HologramRequest request);
  /// Thread-safe, returns at once: presents the hologram as soon as there is a display, before any
  /// later `show`. A later call replaces a hologram that still waits.
  void show_when_possible(HologramRequest request);

  /// Thread-safe: reads back the display's buffer and compares it with the hologram presented last.
  /// `done` is called in the main thread. A difference is an event. Errors: there is no display or
  /// no hologram, or the display system does not allow reading.
  void verify(std::function<void(Result<SlmVerdict>)> done);

  SlmSnapshot snapshot() const { return snapshot_.get(); }

 private:
  /// A call of `show`; its caller may have stopped waiting.
  struct Job {
    HologramRequest request;
    std::promise<Result<void>> done;
    bool abandoned = false;  ///< guarded by mutex_
  };
  struct Pending {
    std::optional<HologramRequest> when_possible;
    std::shared_ptr<Job> job;
    std::vector<std::function<void(Result<SlmVerdict>)>> verify;
  };

  Pending wait_for_work();
  void carry_out(Job& job);
  Result<SlmVerdict> compare_output();
  void try_open();
  Result<void> present(const HologramRequest& request);
  void fault(const Error& why);
  void publish_snapshot(const std::optional<Error>& why);

  SlmConfig config_;
  SlmLoopDeps deps_;
  std::unique_ptr<Display> display_;
  std::optional<HologramRequest> requested_;
  ShownHologram shown_;
  std::int64_t t_presented_mono_ns_ = 0;
  std::int64_t next_try_ns_ = 0;
  std::int64_t next_check_ns_ = 0;
  Guarded<SlmSnapshot> snapshot_;

  std::mutex mutex_;
  std::condition_variable ready_;
  Pending pending_;
  bool closed_ = false;
};

}  // namespace ovws
