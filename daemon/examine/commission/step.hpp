/// The table of steps: what a step is made of, what it finds, and what a commissioning reports.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "daemon/examine/commission/bench.hpp"

namespace ovws::commission {

using examine::Severity;

/// What follows when an offer has been taken.
enum class After { rerun, conclude, stay };

/// A way to go on that a step offers.
struct Offer {
  std::string name;     ///< unique within the step
  std::string text;     ///< what taking it does
  cli::Calls calls{};   ///< in order
  std::string first{};  ///< step to run before the step is run again
  After after = After::rerun;
  bool is_remedy = true;  ///< it may make a failed step pass
  /// The first proposal of a failed step is the best.
  bool is_proposal() const { return is_remedy && after == After::rerun; }
};

/// What a run or an undo of a step found.
struct Outcome {
  bool passed = false;
  examine::Finding verdict;
  std::vector<Offer> offers{};
  std::vector<std::string> commands{};
  Image<std::uint8_t> picture{};  ///< empty: the camera's image at the end
};

/// How to restore what was in use before the first run of a step.
struct Undo {
  cli::Parts parts{};
  cli::Calls calls{};
  std::string text;  ///< what is in use then
};

/// What this commissioning remembers of a step.
struct Memory {
  std::optional<Undo> undo{};     ///< none: not run yet, or nothing to restore
  std::set<std::string> tried{};  ///< names of the offers that were taken
};

/// Results of methods without params, by name, as the daemon reported them at one moment.
using Look = std::map<std::string, nlohmann::json>;
/// The methods that a Look holds.
std::vector<std::string> looked_at();

/// Whether the sensor is a fixed array of lenslets. `config`: as config.get reports it.
bool is_fixed_array(const nlohmann::json& config);

/// Whether this value is true.
bool is_true(const Look& look, const char* method, const char* key);
/// Whether a reference was taken, by the sensor and not from the model.
bool has_measured_reference(const Look& look);
/// Of a step that the daemon does not report: done if it `must` have been, and else not known.
std::optional<bool> done_if(bool must);

/// What the modulator must be able to do for a step.
enum class Needs {
  light,      ///< nothing
  holograms,  ///< a fixed array shows none
  phase       ///< grey levels that are phases; a DMD has two levels
};

struct Step {
  const char* name;
  const char* title;
  const char* purpose;
  /// Whether its result is in use; none: the daemon does not tell.
  std::optional<bool> (*is_done)(const Look&);
  Outcome (*run)(Bench&, Memory&);
  const char* clear = nullptr;    ///< method that clears what was measured; null: nothing was
  const char* cleared = nullptr;  ///< says that it is cleared
  bool is_needed = false;         ///< later steps cannot pass without it
  Needs needs = Needs::light;
};

std::span<const Step> steps();

/// Why the bench needs no such step, in one sentence; empty: it needs it.
std::string needless(const Step& step, const Look& look);

Outcome failed(std::string text, std::string advice = {}, std::vector<Offer> offers = {});
/// With what the daemon said.
Outcome failed(const Error& error, std::string advice = {}, std::vector<Offer> offers = {});
Outcome passed(std::string text);
/// A way that first runs another step. None if it was tried before.
std::vector<Offer> other_first(const Memory& memory, const char* step, const char* text);

/// Restores what the step has changed, or clears what it has measured.
Outcome undone(Bench& bench, const Step& step, const Memory& memory);

// What a commissioning reports.

enum class State {
  open,     ///< not done, or the daemon does not tell
  done,     ///< its result is in use on the daemon, or it passed in this commissioning
  skipped,  ///< by the user, until the step is run; or the bench needs no such step
  failed    ///< the last run did not pass
};

const char* name_of(State state);

struct StepReport : Step {
  State state = State::open;
  bool is_recorded = true;  ///< false: open, because the daemon does not tell whether it was done
  std::optional<examine::Finding> verdict{};  ///< of the last action in this commissioning, or why
                                              ///< the bench needs no such step
  std::vector<Offer> offers{};                ///< after the last run
  bool can_undo = false;                      ///< whether there is something to restore or to clear
  std::string picture{};                      ///< changes with the picture; empty: there is none
  std::vector<std::string> commands{};        ///< shell commands that repair what was found
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

// The steps' functions, by file.

std::span<const Step> device_steps();  ///< doctor, camera, output
std::span<const Step> light_steps();   ///< spot, exposure
std::span<const Step> slm_steps();     ///< registration, lut, settle, clear, flatness
const Step& brightness_step();         ///< as exposure, when the sensor's spots are right
std::span<const Step> sensor_steps();  ///< reference, calibration, loop, save

}  // namespace ovws::commission
