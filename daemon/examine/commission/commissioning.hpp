/// Commissioning of a bench by a running daemon, step by step: for `ovws setup` and the live page.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/commission/report.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::commission {

/// What a check of this machine found.
struct Finding {
  Wellness wellness = Wellness::good;
  std::string name;     ///< "camera.packets"
  std::string meaning;  ///< one sentence
  std::string fix;      ///< a shell command, or a line of the configuration; may be empty
};

/// The ordered steps of a commissioning. There is no file of progress: whether a step is done is
/// derived from what the daemon reports, so that a commissioning resumes at the first step that is
/// not done. Only skips, failures and verdicts live in this object.
///
/// All functions are thread-safe and return at once. Actions run one at a time, in a thread of this
/// object; `report` shows their progress and what they found. An action is refused (Errc::refused)
/// while another one runs, and with Errc::invalid if a name is unknown.
class Commissioning {
 public:
  struct Settings {
    cli::Common daemon;  ///< connection and time-out
    /// Checks of this machine, some seconds, called in the thread of this object. Empty: the step
    /// `doctor` judges by the daemon's status only.
    std::function<std::vector<Finding>()> examine;
  };

  /// Begins by asking the daemon which steps are done, as `look` does.
  explicit Commissioning(Settings settings);
  /// Cancels what runs and waits for its end.
  ~Commissioning();
  Commissioning(const Commissioning&) = delete;
  Commissioning& operator=(const Commissioning&) = delete;

  Report report() const;

  /// Asks the daemon again which steps are done. It is done after each action, too.
  Result<void> look();
  /// Runs a step, also one that is done: it then measures again.
  Result<void> run(std::string_view step);
  /// Marks a step as skipped. What it measured earlier stays in use.
  Result<void> skip(std::string_view step);
  /// Restores the settings from before the step's first run in this commissioning. Where the daemon
  /// cannot restore, as with measurements, it clears what was measured. The verdict says which.
  Result<void> undo(std::string_view step);
  /// Takes an offer of the step's last run, and then runs the step again unless the offer concludes
  /// it.
  Result<void> take(std::string_view step, std::string_view offer);
  /// Ends what runs: a job is cancelled, settings and pattern are restored, the step is failed.
  /// Does nothing if nothing runs.
  void cancel();

  /// One of the above by its name: run, skip, undo, offer, cancel, look. `step` and `offer` are
  /// ignored by those that have none.
  Result<void> act(std::string_view action, std::string_view step, std::string_view offer);

  /// The step's last picture: the camera's image or a graph, 8-bit grey. Empty (width 0): none.
  Image<std::uint8_t> picture(std::string_view step) const;
  /// The same as a PNG file. Errors: Errc::unavailable, field "step": it has none.
  Result<std::string> picture_png(std::string_view step) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The first step that is neither done nor skipped; null: there is none.
const StepReport* next_step(const Report& report);
/// The names of all steps in order.
std::vector<std::string> step_names();

}  // namespace ovws::commission
