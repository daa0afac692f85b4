/// What a commissioning reports: its steps with their states, verdicts and offers, and what runs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/examine/finding.hpp"

namespace ovws::commission {

enum class State {
  open,     ///< not done, or the daemon does not tell
  done,     ///< its result is in use on the daemon, or it passed in this commissioning
  skipped,  ///< by the user, until the step is run; or the bench needs no such step
  failed    ///< the last run did not pass
};

const char* name_of(State state);

/// A way to go on that a step offers.
struct Offer {
  std::string name;         ///< unique within the step
  std::string text;         ///< what taking it does
  bool is_proposal = true;  ///< it may make a failed step pass; the first of these is the best
};

struct StepReport {
  std::string name;        ///< "camera"; constant
  std::string title;       ///< "Camera"; constant
  std::string purpose;     ///< one sentence; constant
  bool is_needed = false;  ///< later steps cannot pass without it; constant
  State state = State::open;
  bool is_recorded = true;  ///< false: open, because the daemon does not tell whether it was done
  std::optional<examine::Finding> verdict{};  ///< of the last action in this commissioning, or why
                                              ///< the bench needs no such step
  std::vector<Offer> offers{};                ///< after the last run
  bool can_undo = false;                ///< whether `undo` has something to restore or to clear
  std::string picture{};                ///< changes with the picture; empty: there is none
  std::vector<std::string> commands{};  ///< shell commands that repair what was found
};

struct Running {
  std::string step;
  double progress = 0.0;  ///< 0 .. 1
  std::string text;       ///< what happens at present
};

struct Report {
  std::optional<Running> running;
  std::vector<StepReport> steps;  ///< in the order in which they are done
};

/// The document `ovws.commission/1`:
///
///     {"schema", "running": null | {"step", "progress", "text"},
///      "steps": [{"name", "title", "purpose", "state": "open|done|skipped|failed",
///        "verdict": null | {"wellness": "good|note|warning|bad", "text", "advice"},
///        "offers": [{"name", "text"}], "can_undo", "picture": null | "id"}]}
///
/// `advice` is "" if nothing is to be done. Commands are part of the advice.
nlohmann::json to_json(const Report& report);

}  // namespace ovws::commission
