/// ovws watch on a terminal: a full-screen view of the bench, updated live.

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/screen/page.hpp"
#include "daemon/ovws/screen/terminal.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/quantity.hpp"
#include "daemon/shared/stream_follower.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPeriod{50};  ///< from one drawing to the next
constexpr double kMissingDaemonTimeoutS = 0.3;    ///< longest wait for a missing daemon
constexpr double kActionTimeoutS = 3.0;           ///< longest wait for the answer to a key
constexpr int kPage = 10;

/// Why the frame is not valid; empty if the messages lack the fields for an explanation.
std::string reason_of(const screen::View& view) {
  for (const char* key : {"verdict", "tracked", "subapertures"}) {
    if (!view.wavefront.contains(key)) return {};
  }
  if (view.status.is_null()) return {};
  return why_not_valid(view.wavefront, view.status);
}

/// A call that a key asks for.
struct Action {
  std::string question;
  std::string method;
  json params;
};

/// The action of a key in this state of the bench; none if the key has none, or if the state is
/// unknown.
std::optional<Action> action_of(int key, const screen::View& view) {
  constexpr double kStep = 1.25;
  constexpr int kFrames = 100;
  if (view.status.is_null()) return std::nullopt;
  if (key == 'r') {
    return Action{fmt::format("take a reference of {} frames", kFrames),
                  "reference.take",
                  {{"frames", kFrames}}};
  }
  if (key == 'c') return Action{"remove the aberration", "aberration.clear", json::object()};
  if (key == 'l') {
    const bool is_open = view.status.at("loop") == "open";
    return Action{is_open ? "close the loop" : "open the loop",
                  is_open ? "loop.close" : "loop.open", json::object()};
  }
  if (key != '+' && key != '-') return std::nullopt;
  const double now_us = view.status.at("camera").at("settings").at("exposure_us").get<double>();
  const double us = std::round(10.0 * (key == '+' ? now_us * kStep : now_us / kStep)) / 10.0;
  return Action{"set the exposure to " + time_text(1e-6 * us), "camera.set", {{"exposure_us", us}}};
}

class WatchScreen {
 public:
  WatchScreen(const Common& common, screen::Terminal terminal)
      : common_(common),
        terminal_(std::move(terminal)),
        stream_(common, "endpoint", {"wavefront", "spots", "status", "event"}, kStreamQueue),
        gatherer_(Clock::now()) {
    common_.timeout_s = kActionTimeoutS;
  }

  int run() {
    while (!was_interrupted() && !quit_) {
      if (output_has_no_reader()) return kError;
      gather(Clock::now() + kPeriod);
      for (int key = terminal_.key(); key != 0 && !quit_; key = terminal_.key()) handle_key(key);
      draw();
    }
    return kOk;
  }

 private:
  void gather(Clock::time_point until) {
    for (auto now = Clock::now(); now < until; now = Clock::now()) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - now);
      auto message = stream_.receive(left);
      if (!message) continue;
      gatherer_.take(message->topic, std::move(message->json), std::move(message->binary),
                     Clock::now());
    }
  }

  /// Acts, and notes the answer in the last row.
  void act(const Action& action) {
    const auto answer = call(common_, action.method, action.params);
    choice_.note = answer ? answer_text(action.method, *answer)
                          : answer.error().error.value("message", std::string("no answer"));
  }

  /// Asks before an action, and acts after `y`. Every other key withdraws the question.
  void ask_or_act(int key) {
    const std::optional<Action> asked = std::exchange(asked_, std::nullopt);
    choice_.note.clear();
    try {
      if (asked && key == 'y') return act(*asked);
      asked_ = action_of(key, gatherer_.view(Clock::now()));
    } catch (const json::exception&) {
      choice_.note = "the daemon's reply has an unknown format: check that it has this version";
    }
    if (asked_) choice_.note = asked_->question + "? y: yes, any other key: no";
  }

  void handle_key(int key) {
    ask_or_act(key);
    if (key == 'q') quit_ = true;
    if (key == 'p') choice_.paused = !choice_.paused;
    choice_.help = (key == '?' || key == 'h') && !choice_.help;
    int& first = choice_.first_mode;
    if (key == 'k') --first;
    if (key == 'j') ++first;
    if (key == 'b') first -= kPage;
    if (key == 'f') first += kPage;
    if (key == 'g') first = 0;
    if (key == 'G') first = 1 << 20;
  }

  /// Draws the newest view. A pause freezes the shown view, but messages are still gathered.
  void draw() {
    const screen::View& newest = gatherer_.view(Clock::now());
    if (!choice_.paused) {
      shown_ = newest;
      shown_.not_valid = reason_of(shown_);
    }
    screen::Canvas canvas = terminal_.blank();
    screen::draw(canvas, shown_, choice_);
    terminal_.show(canvas);
  }

  Common common_;
  screen::Terminal terminal_;
  StreamFollower stream_;
  screen::Gatherer gatherer_;
  screen::View shown_;
  screen::Choice choice_;
  std::optional<Action> asked_;  ///< waits for `y`
  bool quit_ = false;
};

}  // namespace

bool can_show_screen() {
  const char* const term = std::getenv("TERM");
  return isatty(STDIN_FILENO) != 0 && isatty(STDOUT_FILENO) != 0 && term != nullptr &&
         *term != '\0' && std::string_view(term) != "dumb";
}

int show_screen(Common common) {
  // Report a missing daemon at once, like every other command.
  needed(call(common, "config.get", nlohmann::json::object()));
  catch_interrupts({SIGINT, SIGTERM, SIGHUP, SIGQUIT});
  auto terminal = screen::Terminal::open();
  if (!terminal) return report(common, terminal.error());
  try {
    common.timeout_s = kMissingDaemonTimeoutS;
    return WatchScreen(common, std::move(*terminal)).run();
  } catch (const std::exception& error) {  // the terminal is restored here
    return report(common, {Errc::internal, "watch", error.what()});
  }
}

}  // namespace ovws::cli
