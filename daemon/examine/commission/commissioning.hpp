/// Commissioning of a bench by a running daemon, step by step: for `ovws setup` and the live page.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "daemon/examine/commission/step.hpp"

namespace ovws::commission {

/// The ordered steps of a commissioning. There is no file of progress: whether a step is done is
/// derived from what the daemon reports, so that a commissioning resumes at the first step that is
/// not done. Only skips, failures and verdicts live in this object.
///
/// All functions are thread-safe and return at once. Actions run one at a time, in a thread of this
/// object; `report` shows their progress and what they found. An action is refused (Errc::refused)
/// while another one runs, and with Errc::invalid if a name is unknown.
class Commissioning {
 public:
  /// Begins by asking the daemon which steps are done, as `look` does.
  explicit Commissioning(Settings settings);
  /// Cancels what runs and waits for its end.
  ~Commissioning();
  Commissioning(const Commissioning&) = delete;
  Commissioning& operator=(const Commissioning&) = delete;

  Report report() const;

  /// Begins an action. `step` and `offer` are ignored by actions that have none.
  ///
  /// - "run": runs a step, also one that is done: it then measures again.
  /// - "skip": marks a step as skipped. What it measured earlier stays in use.
  /// - "undo": restores the settings from before the step's first run in this commissioning. Where
  ///   the daemon cannot restore, as with measurements, clears what was measured.
  /// - "offer": takes an offer of the step's last run, and then runs the step again unless the
  /// offer
  ///   concludes it.
  /// - "look": asks the daemon again which steps are done, as after each action.
  /// - "cancel": see below.
  Result<void> act(std::string_view action, std::string_view step = {},
                   std::string_view offer = {});
  /// Ends what runs: a job is cancelled, settings and pattern are restored, the step is failed.
  /// Does nothing if nothing runs.
  void cancel();

  /// The step's last picture: the camera's image or a graph, 8-bit grey. Empty (width 0): none.
  Image<std::uint8_t> picture(std::string_view step) const;
  /// The same as a PNG file. Errors: Errc::unavailable, field "step": it has none.
  Result<std::string> picture_png(std::string_view step) const;

 private:
  /// What a step's last action left behind.
  struct Record {
    bool skipped = false, failed = false, is_judged = false;
    Outcome last;      ///< with the newest picture of all
    int pictures = 0;  ///< so far
    Memory memory;
  };

  void work();
  Result<void> begin(const Step* step, std::string text, std::function<void()> action);
  Result<void> take(const Step& step, std::string_view name);
  Bench bench();

  // In the worker thread.
  void look_now();
  void run_now(const Step& step);
  void take_now(const Step& step, const Offer& offer);
  void undo_now(const Step& step);
  void keep(const Step& step, Outcome outcome);

  // With the mutex locked.
  Record& record(const Step& step) { return records_[std::size_t(&step - steps().data())]; }
  const Record& record(const Step& step) const {
    return records_[std::size_t(&step - steps().data())];
  }
  State state_of(const Step& step) const;
  bool can_undo(const Step& step) const;
  StepReport report_of(const Step& step) const;

  const Settings settings_;
  std::atomic<bool> cancelled_{false};
  mutable std::mutex mutex_;  ///< guards all below but the thread
  std::condition_variable wake_;
  bool ending_ = false;
  std::function<void()> next_;
  std::optional<Running> running_;  ///< from the request of an action until its end
  std::vector<Record> records_;
  Look seen_;
  std::thread worker_;
};

/// The names of all steps in order.
std::vector<std::string> step_names();

}  // namespace ovws::commission
