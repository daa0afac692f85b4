#include "daemon/ovws/cli/rejection_recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kMinFrames = 16;
constexpr int kReceiveQueue = 10000;

struct Stamps {
  std::int64_t device_ns = 0, arrival_ns = 0;
};

class Recorder {
 public:
  explicit Recorder(const RecordTask& task) : task_(task) {
    recorded_.recording.modes_waves.resize(task.modes_j.size());
  }

  /// Adds the message's coefficients if they are valid and settled. An error makes the recording
  /// unusable.
  tl::expected<void, CallFailure> take(const json& message) {
    if ((message.at("loop") == "closed") != task_.loop_closed) {
      return tl::make_unexpected(failure(task_.loop_closed
                                             ? "the loop was opened during the recording"
                                             : "another client closed the loop"));
    }
    count(message);
    if (!message.at("valid").get<bool>() || !message.at("settled").get<bool>()) {
      recorded_.why_not_valid = why_not_valid(
          message, {{"slm", {{"pattern", "sensor"}}}, {"sensor", {{"referenced", true}}}});
      return {};
    }
    const auto modes_j = message.at("j").get<std::vector<int>>();
    if (modes_j != stream_modes_j_ && !find_indices(modes_j)) {
      return tl::make_unexpected(failure(
          "the sensor's modes changed during the recording: repeat it without changing them"));
    }
    stamps_.push_back({message.at("t_device_ns").get<std::int64_t>(),
                       message.at("t_arrival_ns").get<std::int64_t>()});
    for (std::size_t k = 0; k < indices_.size(); ++k) {
      recorded_.recording.modes_waves[k].push_back(
          message.at("coefficients").at(indices_[k]).get<double>());
    }
    return {};
  }

  int frames() const { return int(stamps_.size()); }

  study::RecordedLoop end() {
    recorded_.device_clock = std::none_of(stamps_.begin(), stamps_.end(),
                                          [](const Stamps& s) { return s.device_ns == 0; });
    study::Recording kept;
    kept.modes_waves.resize(recorded_.recording.modes_waves.size());
    for (std::size_t i = 0; i < stamps_.size(); ++i) {
      const Stamps &first = stamps_.front(), &now = stamps_[i];
      const double time_s = recorded_.device_clock
                                ? 1e-9 * double(now.device_ns - first.device_ns)
                                : 1e-9 * double(now.arrival_ns - first.arrival_ns);
      if (!kept.times_s.empty() && time_s <= kept.times_s.back())
        continue;  // the clock was set back
      kept.times_s.push_back(time_s);
      for (std::size_t k = 0; k < kept.modes_waves.size(); ++k) {
        kept.modes_waves[k].push_back(recorded_.recording.modes_waves[k][i]);
      }
    }
    recorded_.recording = std::move(kept);
    return std::move(recorded_);
  }

  std::string why_none() const {
    return recorded_.why_not_valid.empty() ? "the camera sent no more"
                                           : "the last one: " + recorded_.why_not_valid;
  }

 private:
  /// Counts lost frames: `gap` counts those lost before publishing, a jump in `seq` those lost
  /// here.
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
  std::optional<std::int64_t> last_seq_;
};

void print_progress(const RecordTask& task, int frames, double seconds_left) {
  const int left = int(std::lround(std::fmax(0.0, seconds_left) + task.seconds_after));
  fmt::print(stderr, "\rloop {}: {} frames, {}:{:02} min left      ",
             task.loop_closed ? "closed" : "open", frames, left / 60, left % 60);
  std::fflush(stderr);
}

}  // namespace

CallFailure failure(std::string message) {
  return {true, {{"message", std::move(message)}}};
}

CallFailure interrupted_failure() {
  return failure("interrupted; the loop is open, and the correction is restored");
}

tl::expected<study::RecordedLoop, CallFailure> record(const Common& common, const RecordTask& task,
                                                      const std::atomic<bool>& interrupted) {
  const auto endpoint = stream_endpoint(common, "endpoint");
  if (!endpoint) return tl::make_unexpected(endpoint.error());
  auto stream = subscribe(common, *endpoint, {"wavefront"}, kReceiveQueue);
  if (!stream) return tl::make_unexpected(failure(stream.error().reason));
  Recorder recorder(task);
  const auto seconds_left = [end = Clock::now() + std::chrono::duration<double>(task.seconds)] {
    return std::chrono::duration<double>(end - Clock::now()).count();
  };
  auto last_print = Clock::now() - 1h;
  while (seconds_left() > 0.0) {
    if (interrupted) return tl::make_unexpected(interrupted_failure());
    if (!common.json && Clock::now() - last_print > 500ms) {
      print_progress(task, recorder.frames(), seconds_left());
      last_print = Clock::now();
    }
    const auto message = stream->receive(100ms);
    if (!message) continue;
    if (auto taken = recorder.take(json_of(message->json)); !taken) {
      return tl::make_unexpected(taken.error());
    }
  }
  if (recorder.frames() >= kMinFrames) return recorder.end();
  return tl::make_unexpected(
      failure(fmt::format("only {} usable frames in {:g} s, {} are needed; {}", recorder.frames(),
                          task.seconds, kMinFrames, recorder.why_none())));
}

}  // namespace ovws::cli
