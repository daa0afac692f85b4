/// The SLM's keeper, on the main thread: shows holograms, checks the output, and opens it anew
/// after a fault.
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

/// One picture to show, with what the frame path must know of it.
struct HologramRequest {
  std::uint64_t hologram_id = 0;
  std::uint64_t sensor_epoch = 0;  ///< 0: nothing to measure with this picture
  HologramKind kind = HologramKind::sensor;
  std::shared_ptr<const Image<std::uint8_t>> grey;
};

struct SlmSnapshot {
  bool healthy = false;
  std::optional<DisplayInfo> info;
  std::uint64_t hologram_id = 0;  ///< shown now; 0: none
  HologramKind kind = HologramKind::sensor;
  std::int64_t t_presented_ns = 0;  ///< UNIX epoch UTC
  std::int64_t t_presented_mono_ns = 0;
  std::int64_t t_settled_mono_ns = 0;
  double present_ms = 0.0;  ///< how long the last call to show a picture took
  std::string fault;        ///< why it is not healthy; empty if it is
  bool at_fault = false;    ///< it is there, and cannot be used until somebody mends that
};

/// What the display's buffer held, against what it was given.
struct SlmVerdict {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0;        ///< of the grey levels given, row by row
  std::uint32_t crc32_shown = 0;  ///< of those found there
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

  /// Main thread: one turn, at most 20 ms when there is nothing to do.
  bool do_work() override;
  /// Main thread: no more turns will come; whoever waits in `show` is answered, and later calls are
  /// refused.
  void close();

  /// Thread-safe, any other thread: shows the picture and returns when the display took it, with an
  /// error if it did not within 2 s; the picture shown before then stays the wanted one.
  Result<void> show(HologramRequest request);
  /// Thread-safe: to be shown as soon as there is a display, before what `show` asks for later.
  void show_when_possible(HologramRequest request);

  /// Thread-safe: reads back what the display shows of the hologram presented last; `done` is
  /// called in the main thread. A difference is an event. Errors: there is no display or no
  /// hologram, or the display system lets nobody read it.
  void verify(std::function<void(Result<SlmVerdict>)> done);

  SlmSnapshot snapshot() const { return snapshot_.get(); }

 private:
  /// A call of `show`; its caller may have stopped waiting.
  struct Job {
    HologramRequest request;
    std::promise<Result<void>> done;
    bool abandoned = false;  ///< guarded by mutex_
  };
  struct Asked {
    std::optional<HologramRequest> when_possible;
    std::shared_ptr<Job> job;
    std::vector<std::function<void(Result<SlmVerdict>)>> verify;
  };

  Asked wait_for_work();
  void carry_out(Job& job);
  Result<SlmVerdict> look();
  void try_open();
  Result<void> present(const HologramRequest& request);
  void fault(const Error& why);
  void publish_snapshot(const std::optional<Error>& why);

  SlmConfig config_;
  SlmLoopDeps deps_;
  std::unique_ptr<Display> display_;
  std::optional<HologramRequest> wanted_;
  ShownHologram shown_;
  double present_ms_ = 0.0;
  std::int64_t t_presented_ns_ = 0;
  std::int64_t t_presented_mono_ns_ = 0;
  std::int64_t next_try_ns_ = 0;
  std::int64_t next_check_ns_ = 0;
  Guarded<SlmSnapshot> snapshot_;

  std::mutex mutex_;
  std::condition_variable ready_;
  Asked asked_;
  bool closed_ = false;
};

}  // namespace ovws
