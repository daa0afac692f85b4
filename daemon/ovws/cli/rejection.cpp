#include "daemon/ovws/cli/rejection.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "daemon/ovws/cli/rejection_recorder.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "proto/json_text.hpp"
#include "proto/requests.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;
using Answer = tl::expected<json, CallFailure>;
using Measured = tl::expected<study::RejectionMeasured, CallFailure>;

constexpr auto kPollInterval = 200ms;
constexpr auto kStepsTimeout = 60s;
constexpr int kRestoreTries = 3;  // a signal may interrupt a call
constexpr int kFirstMode = 3;     // the study ignores piston and tilts

std::atomic<bool> interrupted{false};

/// Closes the loop for the study and restores the previous state: loop open, correction as before.
class BorrowedLoop {
 public:
  /// `correction`: result of correction.get.
  BorrowedLoop(const Common& common, const json& correction)
      : common_(common), modes_(json::array()) {
    for (const json& mode : correction.at("modes")) {
      modes_.push_back({{"j", mode.at("j")}, {"waves", mode.at("waves")}});
    }
  }

  Answer close(const json& params) {
    Answer closed = call(common_, "loop.close", params);
    taken_ = closed || !closed.error().answered;
    return closed;
  }

  /// Opens the loop and restores the correction; does nothing if the loop was never closed.
  Answer restore() {
    Answer done = json();
    for (int tries = 0; taken_ && tries < kRestoreTries; ++tries) {
      done = call(common_, "loop.open", {{"keep", true}});
      if (done) done = call(common_, "correction.set", {{"modes", modes_}});
      if (done) taken_ = false;
    }
    if (done) return done;
    const std::string why = done.error().error.value("message", "unknown error");
    return tl::make_unexpected(CallFailure{done.error().answered,
                                           {{"message", "the correction could not be restored to " +
                                                            json_text(modes_) + ": " + why}}});
  }

 private:
  const Common& common_;
  json modes_;
  bool taken_ = false;
};

/// The modes j >= 3 that are both measured and corrected, in measured order.
Answer common_modes(const Common& common, const LoopSettings& settings) {
  const Answer sensor = call(common, "sensor.get", json::object());
  if (!sensor) return sensor;
  const auto read = sensor->at("modes_j").get<std::vector<int>>();
  const auto holds = [](const std::vector<int>& modes, int j) {
    return std::find(modes.begin(), modes.end(), j) != modes.end();
  };
  for (const int j : settings.modes) {
    if (!holds(read, j)) {
      return tl::make_unexpected(failure(fmt::format("modes: j = {} is not measured", j)));
    }
  }
  std::vector<int> both;
  std::copy_if(read.begin(), read.end(), std::back_inserter(both), [&](int j) {
    return j >= kFirstMode && (settings.modes.empty() || holds(settings.modes, j));
  });
  if (both.empty()) {
    return tl::make_unexpected(failure(fmt::format("modes: none with j >= {}", kFirstMode)));
  }
  return both;
}

tl::expected<void, CallFailure> check_bench(const Common& common) {
  const Answer status = call(common, "system.status", json::object());
  if (!status) return tl::make_unexpected(status.error());
  if (const auto state = status->at("state").get<std::string>(); state != "running") {
    return tl::make_unexpected(
        failure("the daemon is in state " + state + ", not running: ovws status says why"));
  }
  if (!status->at("sensor").at("referenced").get<bool>()) {
    return tl::make_unexpected(
        failure("there is no reference: take one with a good wavefront first, ovws call "
                "reference.take"));
  }
  const Answer loop = call(common, "loop.get", json::object());
  if (!loop) return tl::make_unexpected(loop.error());
  if (!loop->at("closed").get<bool>()) return {};
  return tl::make_unexpected(failure("the loop is closed: open it first, ovws call loop.open"));
}

/// The result of loop.get; an error if the loop was opened.
Answer closed_loop(const Common& common) {
  Answer loop = call(common, "loop.get", json::object());
  if (!loop || loop->at("closed").get<bool>()) return loop;
  const json& why = loop->at("opened_because");
  return tl::make_unexpected(
      failure(fmt::format("the loop was opened after {} steps: {}", loop->at("steps").get<int>(),
                          why.is_string() ? why.get<std::string>() : "no reason given")));
}

/// Waits until the loop has converged: 3 time constants, at least 5 and at most 200 steps.
Answer wait_for_steps(const Common& common, double gain) {
  const int needed = int(std::clamp(std::ceil(3.0 / gain), 5.0, 200.0));
  const auto end = Clock::now() + kStepsTimeout;
  while (true) {
    Answer loop = closed_loop(common);
    if (!loop || loop->at("steps").get<int>() >= needed) return loop;
    if (interrupted) return tl::make_unexpected(interrupted_failure());
    if (Clock::now() > end) {
      return tl::make_unexpected(failure(
          fmt::format("the loop made only {} of its first {} steps in {} s: settled and valid "
                      "frames are rare, see ovws watch",
                      loop->at("steps").get<int>(), needed, kStepsTimeout.count())));
    }
    std::this_thread::sleep_for(kPollInterval);
  }
}

tl::expected<void, CallFailure> record_closed(const Common& common, const RecordTask& task,
                                              double gain, study::RejectionMeasured& measured) {
  const Answer before = wait_for_steps(common, gain);
  if (!before) return tl::make_unexpected(before.error());
  const auto begun = Clock::now();
  auto recorded = record(common, task, interrupted);
  const double took_s = std::chrono::duration<double>(Clock::now() - begun).count();
  const Answer after = closed_loop(common);  // gives a better reason than the stream
  if (!after && !interrupted) return tl::make_unexpected(after.error());
  if (!recorded) return tl::make_unexpected(recorded.error());
  measured.closed = std::move(*recorded);
  measured.loop = *after;
  const int steps = after->at("steps").get<int>() - before->at("steps").get<int>();
  measured.steps_hz = double(steps) / took_s;
  return {};
}

Measured measure(const Common& common, const json& params, double seconds) {
  const auto settings = decode<LoopSettings>(params);
  if (!settings) {
    return tl::make_unexpected(failure(text_of(settings.error())));
  }
  if (const auto ready = check_bench(common); !ready) return tl::make_unexpected(ready.error());
  const Answer modes = common_modes(common, *settings);
  if (!modes) return tl::make_unexpected(modes.error());
  const Answer correction = call(common, "correction.get", json::object());
  if (!correction) return tl::make_unexpected(correction.error());
  study::RejectionMeasured measured;
  measured.modes_j = modes->get<std::vector<int>>();
  measured.segment_s = study::segment_s(seconds);
  auto open = record(common, {false, seconds, seconds, measured.modes_j}, interrupted);
  if (!open) return tl::make_unexpected(open.error());
  measured.open = std::move(*open);
  BorrowedLoop loop(common, *correction);
  tl::expected<void, CallFailure> done;
  if (const Answer closed = loop.close(params); !closed) {
    done = tl::make_unexpected(closed.error());
  } else {
    done = record_closed(common, {true, seconds, 0.0, measured.modes_j}, settings->gain, measured);
  }
  if (const Answer back = loop.restore(); !back) return tl::make_unexpected(back.error());
  if (!done) return tl::make_unexpected(done.error());
  return measured;
}

}  // namespace

int run_rejection(const Common& common, const json& params, double seconds,
                  const std::filesystem::path& folder) {
  std::signal(SIGINT, [](int) { interrupted = true; });
  std::signal(SIGTERM, [](int) { interrupted = true; });
  const Measured measured = measure(common, params, seconds);
  if (!common.json) fmt::print(stderr, "\n");
  if (!measured) return report_failure(common, measured.error());
  const study::RejectionFound found = study::find_rejection(*measured);
  if (found.rejection.empty()) {
    return report(common,
                  {Errc::refused, "",
                   fmt::format("frames are too rare for a spectrum, one every {:.2g} s: record for "
                               "longer (--seconds)",
                               study::median_interval_s(measured->closed.recording.times_s))});
  }
  json summary = study::rejection_summary(*measured, found);
  summary["version"] = OVWS_VERSION;
  summary["seconds"] = seconds;
  const auto written =
      write_findings("rejection", summary, study::rejection_figures(found), folder);
  if (common.json) {
    print("{}\n", json_text(summary));
  } else {
    print("{}see {}\n", study::rejection_text(summary), folder.string());
  }
  return written ? kOk : report(common, written.error());
}

}  // namespace ovws::cli
