/// ovws study rejection: the closed loop's disturbance rejection on a daemon's bench.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <iterator>
#include <optional>
#include <thread>

#include "daemon/examine/status_questions.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/rejection.hpp"
#include "daemon/shared/borrow.hpp"
#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"
#include "proto/requests.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto kStepsTimeout = 60s;
constexpr int kFirstMode = 3;  // the study ignores piston and tilts

constexpr int kMinFrames = 16;
constexpr int kReceiveQueue = 10000;

void stop_if_interrupted() {
  if (was_interrupted()) stop("interrupted; the loop is open, and the correction is restored");
}

struct RecordTask {
  bool loop_closed = false;  ///< required state of the loop; another state is an error
  double seconds = 60.0;
  double seconds_after = 0.0;  ///< remaining time of the study, for the progress line
  std::vector<int> modes_j;
};

struct Stamps {
  std::int64_t device_ns = 0, arrival_ns = 0;
};

class Recorder {
 public:
  explicit Recorder(const RecordTask& task) : task_(task) {
    recorded_.recording.modes_waves.resize(task.modes_j.size());
  }

  /// Takes the coefficients of the message, if it is valid and settled. Throws CallFailed; the
  /// recording cannot be used then.
  void take(const json& message) {
    if ((message.at("loop") == "closed") != task_.loop_closed) {
      stop(task_.loop_closed
               ? "the loop was opened during the recording: repeat the command"
               : "another client closed the loop: repeat the command when no other client uses it");
    }
    count(message);
    if (!message.at("valid").get<bool>() || !message.at("settled").get<bool>()) {
      recorded_.why_not_valid = verdict_text(message);
      return;
    }
    const auto modes_j = message.at("j").get<std::vector<int>>();
    if (modes_j != stream_modes_j_ && !find_indices(modes_j)) {
      stop("the sensor's modes changed during the recording: repeat it without changing them");
    }
    stamps_.push_back({message.at("t_device_ns").get<std::int64_t>(),
                       message.at("t_arrival_ns").get<std::int64_t>()});
    for (std::size_t k = 0; k < indices_.size(); ++k) {
      recorded_.recording.modes_waves[k].push_back(
          message.at("coefficients").at(indices_[k]).get<double>());
    }
    fit_residual_squares_ += std::pow(message.at("fit_residual_px").get<double>(), 2);
    for (const std::size_t k : others_) {
      uncorrected_squares_ += std::pow(message.at("coefficients").at(k).get<double>(), 2);
    }
  }

  int frames() const { return int(stamps_.size()); }

  study::RecordedLoop end() {
    recorded_.device_clock = std::none_of(stamps_.begin(), stamps_.end(),
                                          [](const Stamps& s) { return s.device_ns == 0; });
    ModeSeries kept;
    kept.modes_waves.resize(recorded_.recording.modes_waves.size());
    for (std::size_t i = 0; i < stamps_.size(); ++i) {
      const Stamps &first = stamps_.front(), &now = stamps_[i];
      const double time_s = recorded_.device_clock
                                ? 1e-9 * double(now.device_ns - first.device_ns)
                                : 1e-9 * double(now.arrival_ns - first.arrival_ns);
      if (!kept.times_s.empty() && time_s <= kept.times_s.back())
        continue;  // drop the frame: the clock was set back
      kept.times_s.push_back(time_s);
      for (std::size_t k = 0; k < kept.modes_waves.size(); ++k) {
        kept.modes_waves[k].push_back(recorded_.recording.modes_waves[k][i]);
      }
    }
    recorded_.recording = std::move(kept);
    recorded_.fit_residual_px = std::sqrt(fit_residual_squares_ / frames());
    recorded_.uncorrected_waves = std::sqrt(uncorrected_squares_ / frames());
    return std::move(recorded_);
  }

  std::string why_none() const {
    return recorded_.why_not_valid.empty() ? "the camera sent no more"
                                           : "the last one: " + recorded_.why_not_valid;
  }

 private:
  /// Counts lost frames: `gap` counts frames lost in the daemon before publishing. A jump in `seq`
  /// counts messages lost on the way to this program.
  void count(const json& message) {
    const auto seq = message.at("seq").get<std::int64_t>();
    if (last_seq_) {
      recorded_.lost +=
          message.at("gap").get<int>() + int(std::max<std::int64_t>(0, seq - *last_seq_ - 1));
    }
    last_seq_ = seq;
    ++recorded_.received;
  }

  bool find_indices(const std::vector<int>& modes_j) {
    if (!stream_modes_j_.empty()) return false;
    stream_modes_j_ = modes_j;
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      if (modes_j[k] < kFirstMode || std::ranges::count(task_.modes_j, modes_j[k]) > 0) continue;
      others_.push_back(k);
      recorded_.uncorrected_j.push_back(modes_j[k]);
    }
    for (const int j : task_.modes_j) {
      const auto at = std::find(modes_j.begin(), modes_j.end(), j);
      if (at == modes_j.end()) return false;
      indices_.push_back(std::size_t(at - modes_j.begin()));
    }
    return true;
  }

  const RecordTask& task_;
  study::RecordedLoop recorded_;
  std::vector<Stamps> stamps_;
  std::vector<int> stream_modes_j_;
  std::vector<std::size_t> indices_;  ///< index of each task mode in the message
  std::vector<std::size_t> others_;   ///< indices of recorded_.uncorrected_j
  double fit_residual_squares_ = 0.0, uncorrected_squares_ = 0.0;  ///< sums over the frames
  std::optional<std::int64_t> last_seq_;
};

void print_time_left(const RecordTask& task, int frames, double seconds_left) {
  const int left = int(std::lround(std::fmax(0.0, seconds_left) + task.seconds_after));
  study::print_progress(fmt::format("loop {}: {} frames, {}:{:02} min left",
                                    task.loop_closed ? "closed" : "open", frames, left / 60,
                                    left % 60));
}

/// Records valid, settled frames with device time stamps, or with arrival times if the camera has
/// no clock. Prints progress on stderr unless --json is set. Throws CallFailed: the daemon fails;
/// an interrupt; too few frames; a change of the loop's state or of the sensor's modes.
study::RecordedLoop record(const Common& common, const RecordTask& task) {
  auto stream = needed(open_stream(common, "endpoint", {"wavefront"}, kReceiveQueue));
  Recorder recorder(task);
  const auto seconds_left = [end = Clock::now() + std::chrono::duration<double>(task.seconds)] {
    return std::chrono::duration<double>(end - Clock::now()).count();
  };
  auto last_print = Clock::now() - 1h;
  while (seconds_left() > 0.0) {
    stop_if_interrupted();
    if (!common.json && Clock::now() - last_print > 500ms) {
      print_time_left(task, recorder.frames(), seconds_left());
      last_print = Clock::now();
    }
    if (const auto message = stream.receive(100ms)) recorder.take(json_of(message->json));
  }
  if (recorder.frames() >= kMinFrames) return recorder.end();
  stop(fmt::format("only {} usable frames in {:g} s, {} are needed; {}", recorder.frames(),
                   task.seconds, kMinFrames, recorder.why_none()));
}

/// Modes j >= 3 that the sensor measures and the loop corrects, in measured order.
std::vector<int> common_modes(const Common& common, const LoopSettings& settings) {
  const json sensor = needed(call(common, "sensor.get", json::object()));
  const auto read = sensor.at("modes_j").get<std::vector<int>>();
  const auto holds = [](const std::vector<int>& modes, int j) {
    return std::find(modes.begin(), modes.end(), j) != modes.end();
  };
  for (const int j : settings.modes) {
    if (!holds(read, j)) stop(fmt::format("modes: j = {} is not measured", j));
  }
  std::vector<int> both;
  std::copy_if(read.begin(), read.end(), std::back_inserter(both), [&](int j) {
    return j >= kFirstMode && (settings.modes.empty() || holds(settings.modes, j));
  });
  if (both.empty()) stop(fmt::format("modes: none with j >= {}", kFirstMode));
  return both;
}

tl::expected<void, CallFailure> check_bench(const Common& common) {
  const Answer status = call(common, "system.status", json::object());
  if (!status) return tl::make_unexpected(status.error());
  if (auto why = examine::why_not_ready(*status); !why.empty()) {
    return tl::make_unexpected(failure(std::move(why)));
  }
  if (status->at("loop") == "open") return {};
  return tl::make_unexpected(failure("the loop is closed: open it first, ovws call loop.open"));
}

/// Result of loop.get for a closed loop; throws CallFailed if the loop was opened meanwhile.
json closed_loop(const Common& common) {
  json loop = needed(call(common, "loop.get", json::object()));
  if (loop.at("closed").get<bool>()) return loop;
  const json& why = loop.at("opened_because");
  stop(fmt::format("the loop was opened after {} steps: {}", loop.at("steps").get<int>(),
                   why.is_string() ? why.get<std::string>() : "no reason given"));
}

/// Steps until the loop has converged: 3 time constants, at least 5 and at most 200 steps.
int steps_to_converge(double gain) {
  return int(std::clamp(std::ceil(3.0 / gain), 5.0, 200.0));
}

json wait_for_steps(const Common& common, int wanted) {
  const auto end = Clock::now() + kStepsTimeout;
  while (true) {
    json loop = closed_loop(common);
    if (loop.at("steps").get<int>() >= wanted) return loop;
    stop_if_interrupted();
    if (Clock::now() > end) {
      stop(
          fmt::format("the loop made only {} of its first {} steps in {} s: settled and valid "
                      "frames are rare, see ovws watch",
                      loop.at("steps").get<int>(), wanted, kStepsTimeout.count()));
    }
    std::this_thread::sleep_for(kPollInterval);
  }
}

/// Closes the loop with the settings of `law`, records what it leaves, and restores the loop.
void record_closed(const Common& common, const RecordTask& task, study::MeasuredLaw& law) {
  Borrow loop(common, needed(parts_of(common, {Part::correction, Part::loop})));
  const auto record_steps = [&] {
    needed(call(common, "loop.close", to_json(law.settings)));
    const json before = wait_for_steps(common, steps_to_converge(law.settings.gain));
    const auto begun = Clock::now();
    auto recorded = attempt([&] { return record(common, task); });
    const double took_s = std::chrono::duration<double>(Clock::now() - begun).count();
    const Answer after = attempt([&] { return closed_loop(common); });
    if (!was_interrupted()) needed(after);  // its error says more than the stream's
    law.closed = needed(std::move(recorded));
    law.loop = needed(after);
    const int steps = law.loop.at("steps").get<int>() - before.at("steps").get<int>();
    const double delay_ms = law.loop.at("step").value("delay_ms", 0.0);
    if (steps < 1)
      stop("the loop made no step during the recording: see ovws watch, or record for longer");
    law.timing.step_s = took_s / double(steps);
    law.timing.delay_s = delay_ms > 0.0 ? 1e-3 * delay_ms : law.timing.step_s;  // too few steps
  };
  needed(loop.restore_after(attempt(record_steps)));
}

/// Closes the loop for a moment: loop.identify then knows the steps and their delay.
void measure_steps(const Common& common, LoopSettings settings) {
  constexpr int kSteps = 64;
  settings.law = LawName::integrator;
  Borrow loop(common, needed(parts_of(common, {Part::correction, Part::loop})));
  needed(loop.restore_after(attempt([&] {
    needed(call(common, "loop.close", to_json(settings)));
    wait_for_steps(common, kSteps);
  })));
}

/// Waits until loop.identify, which watches while this program records, has ended.
std::shared_ptr<const LoopModel> identified(const Common& common, const json& job) {
  const Answer done = end_of_job(common, job, {was_interrupted, {}});
  stop_if_interrupted();
  if (!done) stop("loop.identify: " + message_of(done.error()));
  return std::make_shared<const LoopModel>(needed(decode<LoopModel>(done->at("model"))));
}

/// Settings of the loops to measure: those of `params`, with each law if `params` names none.
std::vector<LoopSettings> loops_of(const json& params) {
  const LoopSettings settings = needed(decode<LoopSettings>(params));
  if (params.contains("law")) return {settings};
  std::vector<LoopSettings> all;
  for (const LawName law : {LawName::integrator, LawName::optimised, LawName::predictor}) {
    all.push_back(settings);
    all.back().law = law;
  }
  return all;
}

study::RejectionMeasured measure(const Common& common, const json& params, double seconds) {
  const auto loops = loops_of(params);
  needed(check_bench(common));
  study::RejectionMeasured measured;
  measured.modes_j = common_modes(common, loops.front());
  measured.segment_s = segment_s(seconds);
  const bool needs_model = std::ranges::any_of(
      loops, [](const LoopSettings& one) { return one.law != LawName::integrator; });
  json job;
  if (needs_model) {
    measure_steps(common, loops.front());
    const double watched_s = std::clamp(seconds, limits::kIdentifyS.min, limits::kIdentifyS.max);
    job = needed(call(common, "loop.identify", {{"seconds", watched_s}})).at("job");
  }
  auto left = double(loops.size());
  auto open = attempt([&] {
    return record(common, {false, seconds, left * seconds, measured.modes_j});
  });
  if (!open && needs_model) (void)end_of_job(common, job, {[] { return true; }, {}});
  measured.open = needed(std::move(open));
  if (needs_model) measured.model = identified(common, job);
  for (const LoopSettings& settings : loops) {
    left -= 1.0;
    measured.laws.push_back({settings, {}, {}, {}});
    record_closed(common, {true, seconds, left * seconds, measured.modes_j}, measured.laws.back());
  }
  return measured;
}

}  // namespace

int run_rejection(const Common& common, const json& params, double seconds,
                  const std::filesystem::path& folder) {
  catch_interrupts({SIGINT, SIGTERM});
  auto recorded = attempt([&] { return measure(common, params, seconds); });
  if (!common.json) study::print_progress("");
  const study::RejectionMeasured measured = needed(std::move(recorded));
  const study::RejectionFound found = study::find_rejection(measured);
  for (const study::FoundLaw& law : found.laws) {
    if (!law.rejection.empty()) continue;
    return report(common, {Errc::refused, "",
                           "frames are too rare for a spectrum: record for longer (--seconds)"});
  }
  json summary = study::rejection_summary(measured, found);
  summary["version"] = OVWS_VERSION;
  summary["seconds"] = seconds;
  auto written = remove_findings("rejection", folder);
  if (written) written = write_findings(summary, study::rejection_figures(found), folder);
  print_result(common, summary, study::rejection_text(summary) + "see " + folder.string());
  return written ? kOk : report(common, written.error());
}

}  // namespace ovws::cli
