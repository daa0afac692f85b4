#include "daemon/examine/commission/bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

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
constexpr double kStreamMargin_s = 0.05;  ///< from a frame's arrival to its image message

std::string text_at(const json& object, const char* key, const std::string& otherwise) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : otherwise;
}

Error error_of(const cli::CallFailure& failure) {
  const std::string message = cli::message_of(failure);
  if (!failure.answered) return {Errc::unavailable, "", "the daemon does not answer: " + message};
  const auto found = failure.error.find("data");
  const json data = found != failure.error.end() ? *found : json();
  return {Errc::refused, text_at(data, "field", ""), text_at(data, "reason", message)};
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

Image<float> fractions(const StreamMessage& message) {
  const json header = json_of(message.json);
  Image<float> image(header.at("shape").at(1).get<int>(), header.at("shape").at(0).get<int>());
  const int bits = header.at("significant_bits").get<int>();
  const float full_scale = float((1 << bits) - 1);
  const std::size_t bytes = bits > 8 ? 2 : 1;
  const std::size_t count = std::min(image.pixels.size(), message.binary.size() / bytes);
  for (std::size_t k = 0; k < count; ++k) {
    std::uint16_t value = 0;
    std::memcpy(&value, &message.binary[k * bytes], bytes);
    image.pixels[k] = float(value) / full_scale;
  }
  return image;
}

Result<Subscriber> subscribe_to(const cli::Common& common, const char* key,
                                const std::string& topic, int queue) {
  const auto endpoint = cli::stream_endpoint(common, key);
  if (!endpoint) return fail(error_of(endpoint.error()));
  return cli::subscribe(common, *endpoint, {topic}, queue);
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
  if (all.empty()) return std::nullopt;
  std::ranges::nth_element(all, all.begin() + std::ptrdiff_t(all.size() / 2));
  return all[all.size() / 2];
}

void Bench::say(const std::string& text) {
  progress_(done_, text);
}

Result<json> Bench::call(const std::string& method, const json& params) {
  auto answer = cli::call(settings_.daemon, method, params);
  if (!answer) return fail(error_of(answer.error()));
  return std::move(*answer);
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

Result<void> Bench::pause(double seconds) {
  const auto begin = Clock::now();
  while (seconds_since(begin) < seconds) {
    if (cancelled_) return fail(cancelled_error());
    std::this_thread::sleep_for(
        std::chrono::duration<double>(std::clamp(seconds - seconds_since(begin), 0.0, 0.1)));
  }
  return {};
}

Result<Image<float>> Bench::image() {
  const auto config = call("config.get");
  if (!config) return fail(config.error());
  const auto camera = call("camera.get");
  if (!camera) return fail(camera.error());
  if (config->at("stream").at("image_rate_hz").get<double>() <= 0.0) {
    return fail(Errc::refused, "stream.image_rate_hz",
                "is 0, so that no image is published: set it to 10 in the configuration file, and "
                "reload the daemon");
  }
  const json& settings = camera->at("settings");
  const double exposure_s = 1e-6 * settings.at("exposure_us").get<double>();
  const double frame_s = std::max(exposure_s, 1.0 / settings.at("frame_rate_hz").get<double>());
  const double wait_s = 1e-3 * config->at("slm").at("settle_ms").get<double>() +
                        1e-3 * config->at("camera").at("transfer_ms").get<double>() + exposure_s +
                        frame_s + kStreamMargin_s;
  if (auto waited = pause(wait_s); !waited) return fail(waited.error());
  auto stream = subscribe_to(settings_.daemon, "image_endpoint", "image", 1);
  if (!stream) return fail(stream.error());
  const auto begin = Clock::now();
  while (seconds_since(begin) < kImageTimeout_s + 3.0 * frame_s) {
    if (cancelled_) return fail(cancelled_error());
    if (const auto message = stream->receive(kPollInterval)) return fractions(*message);
  }
  return fail(Errc::unavailable, "camera",
              "no image came: check the camera's cable, its power and its trigger");
}

Result<Image<float>> Bench::image_of(const std::string& pattern) {
  if (auto shown = call("slm.show", {{"pattern", pattern}}); !shown) return fail(shown.error());
  return image();
}

Result<std::vector<WatchedFrame>> Bench::frames(
    double seconds, const std::function<bool(std::span<const WatchedFrame>)>& enough) {
  auto stream = subscribe_to(settings_.daemon, "endpoint", "wavefront", 10'000);
  if (!stream) return fail(stream.error());
  std::vector<WatchedFrame> all;
  const auto begin = Clock::now();
  auto next_look = begin + std::chrono::duration<double>(seconds);
  while (seconds_since(begin) < seconds + cli::kTemplates_s) {
    if (cancelled_) return fail(cancelled_error());
    if (const auto message = stream->receive(kPollInterval)) all.push_back(watched(*message));
    const auto now = Clock::now();
    if (now < next_look) continue;
    if (enough(all)) break;
    next_look = now + kPollInterval;
  }
  return all;
}

Result<std::vector<int>> Bench::lost_spots() {
  constexpr double kWatched_s = 1.0, kFoundShare = 0.5;
  auto stream = subscribe_to(settings_.daemon, "endpoint", "spots", 10'000);
  if (!stream) return fail(stream.error());
  cli::SpotCounts counts;
  for (const auto begin = Clock::now(); seconds_since(begin) < kWatched_s;) {
    if (cancelled_) return fail(cancelled_error());
    if (const auto message = stream->receive(kPollInterval)) counts.add(*message);
  }
  return counts.lost(kFoundShare);
}

Result<cli::Parts> Bench::parts(std::initializer_list<cli::Part> parts) {
  auto found = cli::parts_of(settings_.daemon, parts);
  if (!found) return fail(error_of(found.error()));
  return std::move(*found);
}

cli::Borrow::Hooks Bench::restoring() {
  return {[this] { say("waiting to restore the bench"); },
          [this](const std::string& message) { not_restored_ = message; }};
}

}  // namespace ovws::commission
