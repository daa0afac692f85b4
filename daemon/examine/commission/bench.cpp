#include "daemon/examine/commission/bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/base/median.hpp"
#include "daemon/shared/lost_spots.hpp"
#include "drivers/zmq/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::commission {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollInterval{100};
constexpr double kPatience_s = 30.0;  ///< with a daemon that does not answer while a job runs
constexpr double kImageTimeout_s = 8.0;
constexpr int kStreamQueue = 10'000;

Error error_of(const cli::CallFailure& failure) {
  const std::string message = cli::message_of(failure);
  if (!failure.answered) return {Errc::unavailable, "", "the daemon does not answer: " + message};
  const std::string reason = text_at(failure.error, "/data/reason");
  return {Errc::refused, text_at(failure.error, "/data/field"), reason.empty() ? message : reason};
}

Error cancelled_error() {
  return {Errc::refused, "", "the step was cancelled"};
}

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

WatchedFrame watched(const StreamMessage& message) {
  const json frame = json_of(message.json);
  WatchedFrame watched{frame.at("hologram_id").get<std::uint64_t>(),
                       1e-9 * double(frame.at("t_arrival_ns").get<std::int64_t>()), std::nullopt};
  const json& rms_waves = frame.at("rms_waves");
  if (frame.at("valid") == true && rms_waves.is_number()) watched.rms_waves = rms_waves;
  return watched;
}

Image<float> fractions(const json& header, const StreamMessage& message) {
  Image<float> image(header.at("shape").at(1).get<int>(), header.at("shape").at(0).get<int>());
  const int bits = header.at("significant_bits").get<int>();
  const float full_scale = float((1 << bits) - 1);
  const std::size_t bytes = bits > 8 ? 2 : 1;
  if (message.binary.size() != image.pixels.size() * bytes) {
    throw StepFailed{{Errc::unavailable, "camera", "an image came cut off: run the step again"}};
  }
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    std::uint16_t value = 0;
    std::memcpy(&value, &message.binary[k * bytes], bytes);
    image.pixels[k] = float(value) / full_scale;
  }
  return image;
}

}  // namespace

std::span<const WatchedFrame> newest(std::span<const WatchedFrame> frames, double seconds) {
  std::size_t count = 0;
  while (count < frames.size() &&
         frames.back().arrival_s - frames[frames.size() - 1 - count].arrival_s <= seconds) {
    ++count;
  }
  return frames.last(count);
}

std::optional<double> median_rms_waves(std::span<const WatchedFrame> frames) {
  std::vector<double> all;
  for (const WatchedFrame& frame : frames) {
    if (frame.rms_waves) all.push_back(*frame.rms_waves);
  }
  return all.empty() ? std::nullopt : std::optional(median(std::move(all)));
}

Result<json> Bench::try_call(const std::string& method, const json& params) {
  auto answer = cli::call(settings_.daemon, method, params);
  if (!answer) return fail(error_of(answer.error()));
  return std::move(*answer);
}

json Bench::call(const std::string& method, const json& params) {
  auto answer = try_call(method, params);
  if (!answer) throw StepFailed{answer.error()};
  return std::move(*answer);
}

void Bench::stop_if_cancelled() const {
  if (cancelled_) throw StepFailed{cancelled_error()};
}

Subscriber Bench::subscriber(const char* key, const std::string& topic, int queue) {
  auto stream = cli::open_stream(settings_.daemon, key, {topic}, queue);
  if (!stream) throw StepFailed{error_of(stream.error())};
  return std::move(*stream);
}

Result<json> Bench::job(const std::string& method, const json& params, const std::string& text) {
  if (cancelled_) return fail(cancelled_error());
  const auto show = [&](const json& job) {
    progress_(done_ = job.at("progress").get<double>(), text);
  };
  auto result = cli::call_and_wait(settings_.daemon, method, params,
                                   {[&] { return cancelled_.load(); }, show, kPatience_s});
  if (result) return std::move(*result);
  return fail(cancelled_ ? cancelled_error() : error_of(result.error()));
}

Image<float> Bench::image() {
  const json config = call("config.get");
  const json camera = call("camera.get");
  if (config.at("stream").at("image_rate_hz").get<double>() <= 0.0) {
    throw StepFailed{{Errc::refused, "stream.image_rate_hz",
                      "is 0, so that no image is published: set it to 10 in the configuration "
                      "file, and reload the daemon"}};
  }
  const json& settings = camera.at("settings");
  const double exposure_s = 1e-6 * settings.at("exposure_us").get<double>();
  const double frame_s = std::max(exposure_s, 1.0 / settings.at("frame_rate_hz").get<double>());
  const double wait_s = 1e-3 * config.at("slm").at("settle_ms").get<double>() +
                        1e-3 * config.at("camera").at("transfer_ms").get<double>() + exposure_s +
                        frame_s;
  const std::int64_t from_ns =
      call("system.status").at("t_ns").get<std::int64_t>() + std::int64_t(1e9 * wait_s);
  Subscriber stream = subscriber("image_endpoint", "image", 1);
  const auto begin = Clock::now();
  while (seconds_since(begin) < wait_s + kImageTimeout_s + 3.0 * frame_s) {
    stop_if_cancelled();
    const auto message = stream.receive(kPollInterval);
    if (!message) continue;
    const json header = json_of(message->json);
    if (header.at("t_arrival_ns").get<std::int64_t>() >= from_ns)
      return fractions(header, *message);
  }
  throw StepFailed{{Errc::unavailable, "camera",
                    "no image came: check the camera's cable, its power and its trigger"}};
}

Image<float> Bench::image_of(const std::string& pattern) {
  call("slm.show", {{"pattern", pattern}});
  return image();
}

std::vector<WatchedFrame> Bench::frames(
    double seconds, const std::function<bool(std::span<const WatchedFrame>)>& enough) {
  Subscriber stream = subscriber("endpoint", "wavefront", kStreamQueue);
  std::vector<WatchedFrame> all;
  const auto begin = Clock::now();
  auto next_look = begin + std::chrono::duration<double>(seconds);
  while (seconds_since(begin) < seconds + cli::kTemplates_s) {
    stop_if_cancelled();
    if (const auto message = stream.receive(kPollInterval)) all.push_back(watched(*message));
    const auto now = Clock::now();
    if (now < next_look) continue;
    if (enough(all)) break;
    next_look = now + kPollInterval;
  }
  return all;
}

std::vector<int> Bench::lost_spots() {
  constexpr double kWatched_s = 1.0, kFoundShare = 0.5;
  Subscriber stream = subscriber("endpoint", "spots", kStreamQueue);
  cli::SpotCounts counts;
  for (const auto begin = Clock::now(); seconds_since(begin) < kWatched_s;) {
    stop_if_cancelled();
    if (const auto message = stream.receive(kPollInterval)) counts.add(*message);
  }
  return counts.lost(kFoundShare);
}

cli::Parts Bench::parts(std::initializer_list<cli::Part> parts) {
  auto found = cli::parts_of(settings_.daemon, parts);
  if (!found) throw StepFailed{error_of(found.error())};
  return std::move(*found);
}

cli::Borrow::Hooks Bench::restoring() {
  return {[this] { say("waiting to restore the bench"); },
          [this](const std::string& message) { not_restored_ = message; }};
}

}  // namespace ovws::commission
