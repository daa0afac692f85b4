/// ovws replay: measures a recording again and compares the results bit for bit.
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "core/port/clock.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovwsd/record/loop_player.hpp"
#include "daemon/ovwsd/record/player.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

struct Tally {
  std::uint64_t frames = 0, replayed = 0, same = 0, valid = 0;
  std::string first_reason, first_difference;
};

json line_of(const PlayedFrame& frame) {
  json out{{"frame_id", frame.recorded.frame_id},
           {"t_arrival_ns", frame.recorded.t_arrival_ns},
           {"replayed", frame.replayed},
           {"same", frame.same},
           {"valid", frame.valid},
           {"j", frame.modes_j},
           {"coefficients", nullptr},
           {"sigma", nullptr}};
  if (!frame.valid) return out;
  out["coefficients"] = frame.coefficients;
  out["sigma"] = frame.sigma_waves;
  return out;
}

void count(const PlayedFrame& frame, Tally& tally) {
  ++tally.frames;
  tally.replayed += frame.replayed;
  tally.same += frame.same;
  tally.valid += frame.valid;
  const std::string id = std::to_string(frame.recorded.frame_id);
  if (!frame.replayed && tally.first_reason.empty()) {
    tally.first_reason = "frame " + id + ": " + frame.reason;
  }
  if (frame.replayed && !frame.same && tally.first_difference.empty()) {
    tally.first_difference = "frame " + id;
  }
}

/// Sleeps until the frame is due: its recorded time since the first frame, divided by `speed`.
void wait_for(const PlayedFrame& frame, std::int64_t first_ns, std::int64_t begun_ns,
              double speed) {
  if (speed <= 0.0) return;
  constexpr double kMaxWaitNs = 1e18;  // limit of the clock's range
  const double after_ns =
      std::min(double(frame.recorded.t_arrival_mono_ns - first_ns) / speed, kMaxWaitNs);
  const double now_ns = double(monotonic_ns() - begun_ns);
  if (after_ns > now_ns)
    std::this_thread::sleep_for(std::chrono::duration<double, std::nano>(after_ns - now_ns));
}

/// Waits for a line on standard input. False: end of input.
bool wait_for_enter() {
  std::string line;
  return bool(std::getline(std::cin, line));
}

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

json loop_content(const PlayedLoop& loop) {
  if (loop.runs == 0 && loop.reason.empty()) return nullptr;
  return {{"runs", loop.runs},
          {"decisions", loop.decisions},
          {"same", loop.same},
          {"first_difference", text_or_null(loop.first_difference)},
          {"not_all_because", text_or_null(loop.reason)}};
}

void print_loop(const PlayedLoop& loop) {
  if (loop.runs == 0 && loop.reason.empty()) return;
  print("closed loop: closed {} times, {} decisions repeated, {} of them bit for bit the same\n",
        loop.runs, loop.decisions, loop.same);
  if (!loop.first_difference.empty()) {
    print("first different decision: after {}\n", loop.first_difference);
  }
  if (!loop.reason.empty()) print("not all decisions were repeated: {}\n", loop.reason);
}

int print_summary(const Common& common, const ReplayOptions& options, const Tally& tally,
                  const PlayedLoop& loop) {
  const bool all_same = tally.same == tally.replayed && loop.same == loop.decisions &&
                        tally.replayed + loop.decisions > 0;
  if (common.json) {
    print("{}\n", json_text({{"frames", tally.frames},
                             {"replayed", tally.replayed},
                             {"same", tally.same},
                             {"valid", tally.valid},
                             {"first_not_replayed", text_or_null(tally.first_reason)},
                             {"first_difference", text_or_null(tally.first_difference)},
                             {"loop", loop_content(loop)}}));
    return all_same ? kOk : kError;
  }
  print("{}: {} frames, {} replayed, {} of them bit for bit the same, {} valid\n", options.path,
        tally.frames, tally.replayed, tally.same, tally.valid);
  if (!tally.first_reason.empty()) print("first not replayed: {}\n", tally.first_reason);
  if (!tally.first_difference.empty()) print("first difference: {}\n", tally.first_difference);
  print_loop(loop);
  return all_same ? kOk : kError;
}

}  // namespace

int replay_recording(const Common& common, const ReplayOptions& options) {
  auto player = Player::open(options.path);
  if (!player) return report(common, player.error());
  const auto& recorded = (*player)->reader().frames();
  const std::int64_t first_ns = recorded.empty() ? 0 : recorded.front().t_arrival_mono_ns;
  const std::int64_t begun_ns = monotonic_ns();
  Tally tally;
  while (true) {
    const auto played = (*player)->step();
    if (!played) return report(common, played.error());
    if (!*played) break;
    count(**played, tally);
    wait_for(**played, first_ns, begun_ns, options.speed);
    if (options.frames || options.step) print("{}\n", json_text(line_of(**played)));
    if (!options.step) continue;
    std::fflush(stdout);
    if (!wait_for_enter()) break;
  }
  const auto loop = replay_loop((*player)->reader());
  if (!loop) return report(common, loop.error());
  return print_summary(common, options, tally, *loop);
}

}  // namespace ovws::cli
