/// ovws setup: the commissioning as a conversation on a terminal.
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "daemon/examine/commission/commissioning.hpp"
#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/screen/picture_text.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/ovws/text/wrap.hpp"
#include "daemon/shared/atomic_file.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using commission::Commissioning;
using commission::Offer;
using commission::Report;
using commission::State;
using commission::StepReport;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kStepPollInterval{100};
constexpr double kPatience_s = 10.0;
constexpr std::size_t kPictureColumns = 56;  ///< at most
constexpr std::size_t kIndent = 2;
constexpr int kMaxProposals = 6;  ///< that are taken for one step without a question

constexpr const char* kHelp =
    "  Enter  run the step; after it: go on, or take the proposal if it has failed\n"
    "  1-9    take this offer\n"
    "  y      run the repair's command in a shell\n"
    "  r      repeat the step\n"
    "  s      skip the step\n"
    "  u      undo the step\n"
    "  q      quit; ovws setup goes on at the first step that is not known as done\n";

struct SetupOptions {
  std::vector<std::string> steps;  ///< run these only; empty: all from the first that is not done
  std::string from;                ///< begin with this step, even if it is done; empty: no
  std::string folder;              ///< for the pictures as PNG files; empty: they are not written
  std::string config_path;         ///< for the checks of this machine; empty: the service's
  const CLI::Option* endpoint = nullptr;  ///< for the same checks, if it is given
  bool yes = false;                       ///< no questions: take each step's proposal
  bool list = false;                      ///< only list the steps and their states
};

std::string state_of(const StepReport& step) {
  return step.state == State::open && !step.is_recorded ? "not recorded"
                                                        : commission::name_of(step.state);
}

const char* shown(const examine::Finding& verdict) {
  return examine::names_of(verdict.severity).shown;
}

void print_wrapped(const std::string& text) {
  print("{}\n", wrapped(text, terminal_columns(), kIndent));
}

/// The step's place in the order, from 1.
std::size_t number_of(const std::string& name) {
  const auto names = commission::step_names();
  return std::size_t(std::ranges::find(names, name) - names.begin()) + 1;
}

/// Why a step is passed over.
std::string why_not_run(const StepReport& step) {
  const bool is_explained = step.state == State::skipped && step.verdict;
  return is_explained ? step.verdict->text : state_of(step) + " already";
}

/// How a step's turn ended.
enum class Turn { next, quit, stuck };

/// What comes next in a step's turn.
struct Move {
  std::string action{};  ///< of Commissioning; empty: the turn has ended as `end`
  std::string offer{};
  Turn end = Turn::next;
};

/// A daemon that measures may answer late. A list must not wait long for one that is absent.
Common patient(Common common, const SetupOptions& options) {
  if (!options.list) common.timeout_s = std::max(common.timeout_s, kPatience_s);
  return common;
}

/// Reads single keys of the terminal at standard input, without Enter, that are pressed from its
/// construction on. The destructor restores the terminal.
class Keyboard {
 public:
  Keyboard() {
    tcgetattr(STDIN_FILENO, &before_);
    termios single = before_;
    single.c_lflag &= tcflag_t(~(ICANON | ECHO));
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &single);  // discards earlier keys
  }
  ~Keyboard() { tcsetattr(STDIN_FILENO, TCSANOW, &before_); }
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// The next key, '\n' for Enter; none at the end of the input or after a signal.
  std::optional<char> next() {
    constexpr int kPollMs = 100;  // a signal may be handled in another thread
    while (!was_interrupted()) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (poll(&input, 1, kPollMs) <= 0) continue;
      char key = 0;
      if (read(STDIN_FILENO, &key, 1) != 1) return std::nullopt;
      return key == '\r' ? '\n' : key;
    }
    return std::nullopt;
  }

 private:
  termios before_{};
};

class Conversation {
 public:
  Conversation(const Common& common, const SetupOptions& options)
      : common_(common),
        options_(options),
        is_quiet_(common.json),
        commissioning_({patient(common, options), [this] {
                          return examine_bench(common_, options_.config_path, options_.endpoint);
                        }}) {}

  int run();

 private:
  StepReport report_of(const std::string& name) const;
  std::vector<std::string> plan() const;
  void wait();
  Turn turn(const std::string& name);
  Turn before(const std::string& name, bool& is_run);
  std::optional<Move> after(const std::string& name);
  Move after_unasked(const StepReport& step, int& proposals) const;
  bool act(const Move& move, const std::string& name);
  char ask(const std::string& question);
  void show_step(const StepReport& step) const;
  void show_result(const StepReport& step, double seconds);
  void show_others(const Report& earlier, const std::string& name) const;
  void show_picture(const StepReport& step);
  void run_commands(const StepReport& step);
  int list() const;
  int end(Turn turn);

  Common common_;
  SetupOptions options_;
  bool is_quiet_;
  Clock::time_point begun_ = Clock::now();
  Commissioning commissioning_;
};

StepReport Conversation::report_of(const std::string& name) const {
  const Report report = commissioning_.report();
  return *std::ranges::find(report.steps, name, &StepReport::name);
}

/// The names of the steps to go through. Those of the command line are run even if they are done.
std::vector<std::string> Conversation::plan() const {
  if (!options_.steps.empty()) return options_.steps;
  auto names = commission::step_names();
  if (!options_.from.empty()) names.erase(names.begin(), std::ranges::find(names, options_.from));
  return names;
}

/// Waits for the end of what runs, and shows its progress. Ctrl-C cancels it.
void Conversation::wait() {
  while (const auto running = commissioning_.report().running) {
    if (was_interrupted()) commissioning_.cancel();
    if (!is_quiet_ && !running->step.empty()) {
      const double percent = 100.0 * running->progress;
      study::print_progress(running->text +
                            (percent > 0.0 ? fmt::format(": {:.0f} %", percent) : ""));
    }
    std::this_thread::sleep_for(kStepPollInterval);
  }
  study::print_progress("");
}

char Conversation::ask(const std::string& question) {
  Keyboard keyboard;  // before the question: keys from then on count
  print("{}\n", wrapped("> " + question, terminal_columns(), kIndent));
  std::fflush(stdout);
  constexpr char kEndOfInput = 4;  // Ctrl-D
  const char key = keyboard.next().value_or('q');
  return key == kEndOfInput ? 'q' : key;
}

void Conversation::show_step(const StepReport& step) const {
  if (is_quiet_) return;
  print("\n{}. {} ({})\n", number_of(step.name), step.title, step.name);
  print_wrapped(std::string("  ") + step.purpose);
}

void Conversation::show_picture(const StepReport& step) {
  if (step.picture.empty()) return;
  if (!options_.folder.empty()) {
    std::error_code ignored;  // replace_file reports it
    std::filesystem::create_directories(options_.folder, ignored);
    const auto path = std::filesystem::path(options_.folder) /
                      fmt::format("{:02}-{}.png", number_of(step.name), step.name);
    const auto written = commissioning_.picture_png(step.name).and_then(
        [&](const auto& png) { return replace_file(path.string(), png); });
    if (!written) fmt::print(stderr, "ovws: {}\n", text_of(written.error()));
    if (!is_quiet_ && written) print("  picture: {}\n", path.string());
  }
  if (is_quiet_ || isatty(STDOUT_FILENO) == 0) return;
  const char* const term = std::getenv("TERM");
  const char* const no_colour = std::getenv("NO_COLOR");
  const bool has_greys = term != nullptr && std::strstr(term, "256color") != nullptr &&
                         (no_colour == nullptr || *no_colour == '\0');
  const int columns = int(std::min(kPictureColumns, terminal_columns()));
  print("{}", screen::picture_text(commissioning_.picture(step.name), columns,
                                   has_greys ? screen::Shades::blocks : screen::Shades::ascii));
}

void Conversation::show_result(const StepReport& step, double seconds) {
  show_picture(step);
  if (is_quiet_ || !step.verdict) return;
  print_wrapped(fmt::format("  {}: {} ({})", shown(*step.verdict), step.verdict->text,
                            time_text(std::round(10.0 * seconds) / 10.0)));
  if (!step.verdict->advice.empty()) print_wrapped("  " + step.verdict->advice);
  for (std::size_t k = 0; k < step.offers.size(); ++k) {
    print_wrapped(fmt::format("  {} {}", k + 1, step.offers[k].text));
  }
}

/// Shows what other steps found that ran since `earlier`.
void Conversation::show_others(const Report& earlier, const std::string& name) const {
  const Report now = commissioning_.report();
  for (std::size_t k = 0; !is_quiet_ && k < now.steps.size(); ++k) {
    const StepReport& step = now.steps[k];
    if (step.name == name || step.picture == earlier.steps[k].picture || !step.verdict) continue;
    print_wrapped(
        fmt::format("  {}: {}: {}", step.title, shown(*step.verdict), step.verdict->text));
  }
}

/// Asks before a step is run. Turn::next with `is_run` false: it is skipped.
Turn Conversation::before(const std::string& name, bool& is_run) {
  while (true) {
    const StepReport step = report_of(name);
    const char key = ask(std::string("Enter runs it, s skips it") +
                         (step.can_undo ? ", u undoes it" : "") + ", q quits, ? help");
    if (key == 'q') return Turn::quit;
    if (key == '?') print("{}", kHelp);
    if (key == 'u' && step.can_undo) {
      (void)commissioning_.act("undo", name);
      wait();
      show_result(report_of(name), 0.0);
    }
    if (key == 's') {
      (void)commissioning_.act("skip", name);
      wait();
      is_run = false;
      return Turn::next;
    }
    if (key == '\n') return Turn::next;
  }
}

/// False: the action was refused.
bool Conversation::act(const Move& move, const std::string& name) {
  const auto begun = Clock::now();
  const Report earlier = commissioning_.report();
  if (const auto done = commissioning_.act(move.action, name, move.offer); !done) {
    fmt::print(stderr, "ovws: {}\n", text_of(done.error()));
    return false;
  }
  wait();
  show_others(earlier, name);
  show_result(report_of(name), std::chrono::duration<double>(Clock::now() - begun).count());
  return true;
}

void Conversation::run_commands(const StepReport& step) {
  for (const std::string& command : step.commands) {
    if (ask(command + "   y runs it, any other key does not") != 'y') continue;
    if (std::system(command.c_str()) != 0) print("  it failed\n");
  }
}

/// Without questions: takes proposals until the step passes. `proposals`: that were taken.
Move Conversation::after_unasked(const StepReport& step, int& proposals) const {
  if (step.state != State::failed) return {};
  const auto proposal = std::ranges::find(step.offers, true, &Offer::is_proposal);
  if (proposal == step.offers.end() || proposals == kMaxProposals) {
    return {.end = step.is_needed ? Turn::stuck : Turn::next};
  }
  if (!is_quiet_) print_wrapped("  taken: " + proposal->text);
  ++proposals;
  return {"offer", proposal->name};
}

/// Asks what comes after an action; none: the key has no meaning, ask again.
std::optional<Move> Conversation::after(const std::string& name) {
  const StepReport step = report_of(name);
  const bool has_failed = step.state == State::failed;
  const auto proposal = std::ranges::find(step.offers, true, &Offer::is_proposal);
  const bool is_proposed = has_failed && proposal != step.offers.end();
  std::string question = is_proposed  ? "Enter: " + proposal->text
                         : has_failed ? std::string("Enter repeats it")
                                      : std::string("Enter goes on");
  if (!step.offers.empty()) question += ", a number takes an offer";
  if (!step.commands.empty()) question += ", y runs the repairs";
  question += ", r repeats, s skips, ";
  if (step.can_undo) question += "u undoes, ";
  const char key = ask(question + "q quits, ? help");
  if (key == 'q') return Move{.end = Turn::quit};
  if (key == '?') print("{}", kHelp);
  const bool is_repaired = key == 'y' && !step.commands.empty();
  if (is_repaired) run_commands(step);
  if (key == 's') (void)commissioning_.act("skip", name);
  wait();
  if (key == 's' || (key == '\n' && !has_failed)) return Move{};
  if (key == 'u' && step.can_undo) return Move{"undo"};
  if (key == '\n' && is_proposed) return Move{"offer", proposal->name};
  if (key == 'r' || is_repaired || key == '\n') return Move{"run"};
  const std::size_t number = std::size_t(key - '1');
  if (key >= '1' && number < step.offers.size()) return Move{"offer", step.offers[number].name};
  return std::nullopt;
}

Turn Conversation::turn(const std::string& name) {
  bool is_run = true;
  if (!options_.yes) {
    const Turn asked = before(name, is_run);
    if (asked != Turn::next || !is_run) return asked;
  }
  int proposals = 0;
  Move move{"run"};
  while (!move.action.empty()) {
    if (!act(move, name)) return Turn::stuck;
    std::optional<Move> next;
    while (!next && !was_interrupted()) {
      next = options_.yes ? after_unasked(report_of(name), proposals) : after(name);
    }
    move = next.value_or(Move{.end = Turn::quit});
  }
  return move.end;
}

int Conversation::list() const {
  const auto status = call(common_, "system.status", nlohmann::json::object());
  if (!status && !status.error().answered) return report_failure(common_, status.error());
  const Report report = commissioning_.report();
  if (common_.json) return print_result(common_, to_json(report), "");
  for (const StepReport& step : report.steps) {
    print("{:<12} {:<13} {}\n", state_of(step), step.name,
          wrapped(step.purpose, terminal_columns(), 0));
  }
  if (std::ranges::count(report.steps, false, &StepReport::is_recorded) > 0) {
    print_wrapped(
        "not recorded: the daemon keeps nothing that tells whether the step was done; ovws setup "
        "asks again.");
  }
  return kOk;
}

int Conversation::end(Turn turn) {
  const Report report = commissioning_.report();
  if (common_.json) print("{}\n", json_text(to_json(report)));
  const auto status = call(common_, "system.status", nlohmann::json::object());
  if (!status && !status.error().answered) return report_failure(common_, status.error());
  const bool has_failed = std::ranges::any_of(
      report.steps, [](const StepReport& step) { return step.state == State::failed; });
  if (is_quiet_) return has_failed ? kError : kOk;
  std::string failed;
  for (const StepReport& step : report.steps) {
    if (step.state == State::failed)
      failed += (failed.empty() ? "" : ", ") + std::string(step.name);
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begun_).count();
  print_wrapped(fmt::format("\n{} after {}{}", turn == Turn::next ? "The end, reached" : "Ended",
                            time_text(std::round(seconds)),
                            failed.empty() ? "." : "; failed: " + failed + "."));
  const bool is_complete = std::ranges::all_of(
      report.steps, [](const StepReport& step) { return step.state == State::done; });
  if (is_complete)
    print_wrapped(
        "Next: ovws check -o report.html measures how good the bench is, and what to improve "
        "first.");
  return has_failed ? kError : kOk;
}

int Conversation::run() {
  catch_interrupts();
  wait();
  if (options_.list) return list();
  Turn last = Turn::next;
  for (const std::string& name : plan()) {
    const StepReport step = report_of(name);
    show_step(step);
    const bool is_chosen = !options_.steps.empty() || name == options_.from;
    if (!is_chosen && (step.state == State::done || step.state == State::skipped)) {
      if (!is_quiet_) print_wrapped("  " + why_not_run(step));
      continue;
    }
    last = turn(name);
    if (was_interrupted()) last = Turn::quit;
    if (last != Turn::next) break;
  }
  return end(last);
}

Result<void> check_names(const SetupOptions& options) {
  auto names = options.steps;
  if (!options.from.empty()) names.push_back(options.from);
  const auto known = commission::step_names();
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const auto near = nearest_name(name, known);
    return fail(Errc::invalid, name,
                near ? "is no step; did you mean " + *near + "?"
                     : std::string("is no step; ovws setup --list lists them"));
  }
  return {};
}

/// Returns kOk if every step that it came to is done or skipped, also if the user quits then;
/// kError if one has failed; kNoDaemon if no daemon answers.
int set_up(const Common& common, const SetupOptions& options) {
  if (const auto good = check_names(options); !good) return report_mistake(common, good.error());
  const bool has_questions = !options.yes && !options.list;
  if (has_questions && (common.json || isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0)) {
    return report_mistake(
        common, {Errc::invalid, "setup", "asks questions: run it on a terminal, or with --yes"});
  }
  return Conversation(common, options).run();
}

}  // namespace

void add_setup(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "setup",
      "commission the bench step by step, from the first check to a closed loop, by questions on "
      "the terminal; begins at the first step that is not known as done",
      set_up);
  command.footer(
      "Each step says what it found and what to do. Keys: Enter runs the step, goes on, or takes\n"
      "the proposal of a step that has failed; s skips, u undoes, r repeats, a number takes an\n"
      "offer, q quits, ? shows help. Nothing is lost by quitting: results are in use on the\n"
      "daemon at once, and the last step saves the settings.\n\n"
      "Exit codes: 0 no step has failed; 1 a step has failed; 2 the command line is wrong; 3 no\n"
      "daemon answered in time.");
  command.add_option("steps", options.steps, "names of steps to run (default: all)");
  command.add_option("--from", options.from, "name of the step to begin with, done or not");
  command.add_flag("--yes,-y", options.yes,
                   "no questions: run every step that is not done, and take the proposals of "
                   "those that fail");
  command.add_flag("--list", options.list, "list the steps and their states only");
  command.add_option("--output,-o", options.folder, "folder for the steps' pictures as PNG files");
  command.add_option("--config,-c", options.config_path,
                     "configuration file for the checks of this machine (default: the settings "
                     "that the daemon uses)");
  options.endpoint = app.get_option("--endpoint");
}

}  // namespace ovws::cli
