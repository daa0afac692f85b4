#include "daemon/web/feeds.hpp"

#include <spdlog/spdlog.h>

#include <memory>

#include "core/port/clock.hpp"
#include "daemon/shared/stream_follower.hpp"
#include "daemon/web/picture.hpp"
#include "proto/json_text.hpp"
#include "proto/slow_camera.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr milliseconds kReceiveTimeout{100};
constexpr milliseconds kSilence{3000};  ///< `status` comes once per second
constexpr milliseconds kHealthPeriod{250};
constexpr milliseconds kPollPeriod{2000};
/// While the loop or a slider changes the hologram many times per second, most frames are not
/// valid; the last valid one stays on screen for this time, so that the page does not flicker.
constexpr milliseconds kValidHold{500};
constexpr milliseconds kMinPollInterval{150};  ///< minimum interval of requests after changes
constexpr int kNumbersQueue = 1000;
constexpr int kImagesQueue = 4;

double seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

void SpotShelf::add(std::uint64_t frame_id, std::string packet) {
  const std::scoped_lock lock(mutex_);
  kept_.emplace_back(frame_id, std::move(packet));
  if (kept_.size() > kFrames) kept_.pop_front();
}

std::optional<std::string> SpotShelf::of_frame(std::uint64_t frame_id) const {
  const std::scoped_lock lock(mutex_);
  for (auto kept = kept_.rbegin(); kept != kept_.rend(); ++kept) {
    if (kept->first == frame_id) return kept->second;
  }
  return std::nullopt;
}

Feeds::Feeds(const cli::Common& common, Board& board, std::function<ServerFacts()> server_facts)
    : common_(common),
      board_(board),
      server_facts_(std::move(server_facts)),
      view_(common),
      numbers_([this] { take_numbers(); }),
      pictures_([this] { take_images(); }),
      polling_([this] { poll_bench(); }) {}

Feeds::~Feeds() {
  stop_ = true;
  for (std::thread* thread : {&numbers_, &pictures_, &polling_}) thread->join();
}

void Feeds::sleep_unless_stopped(milliseconds time) const {
  const auto end = Clock::now() + time;
  while (!stop_ && Clock::now() < end) std::this_thread::sleep_for(milliseconds(20));
}

void Feeds::take_numbers() {
  facts_.is_followed = true;
  cli::StreamFollower stream(common_, "endpoint",
                             {"wavefront", "refined", "spots", "status", "event"}, kNumbersQueue);
  while (!stop_) {
    publish_health();
    if (auto message = stream.receive(kReceiveTimeout)) take(std::move(*message));
  }
}

/// Subscribes to images, but only while a browser is connected.
void Feeds::take_images() {
  while (!stop_) {
    if (!watched()) {
      sleep_unless_stopped(kReceiveTimeout);
      continue;
    }
    cli::StreamFollower stream(common_, "image_endpoint", {"image"}, kImagesQueue);
    while (!stop_ && watched()) {
      if (auto message = stream.receive(kReceiveTimeout)) take(std::move(*message));
    }
  }
}

/// Queries the daemon soon after a change of hologram or settings, and every kPollPeriod.
void Feeds::poll_bench() {
  std::int64_t polled_change = -1;
  auto polled_at = Clock::time_point{};
  while (!stop_) {
    const std::int64_t change = hologram_change_;
    const bool due = change != polled_change || Clock::now() - polled_at > kPollPeriod;
    if (!due || !watched()) {
      sleep_unless_stopped(milliseconds(40));
      continue;
    }
    polled_change = change;
    polled_at = Clock::now();
    try {
      const auto view = view_.look(jobs_);
      if (view) board_.put(Slot::bench, framed(json_text(*view)));
    } catch (const json::exception& error) {
      spdlog::warn("a reply of the daemon has an unknown format: {}", error.what());
      sleep_unless_stopped(kPollPeriod);
    }
    sleep_unless_stopped(kMinPollInterval);
  }
}

void Feeds::take(StreamMessage message) {
  const std::string topic = message.topic;
  try {
    if (message.topic == "wavefront") take_wavefront(message);
    if (message.topic == "status") take_status(message);
    if (message.topic == "spots") take_spots(message);
    if (message.topic == "refined") board_.put(Slot::refined, framed(message.json));
    if (message.topic == "event") look_again();
    if (message.topic == "event") board_.append(Series::event, framed(message.json));
    if (message.topic == "image") take_image(std::move(message));
  } catch (const json::exception& error) {
    spdlog::warn("a message \"{}\" has an unknown format: {}", topic, error.what());
  }
}

void Feeds::take_wavefront(const StreamMessage& message) {
  json wavefront = json_of(message.json);
  if (const auto bin = trend_.add(wavefront)) board_.append(Series::trend, framed(json_text(*bin)));
  if (const auto bin = history_.add(wavefront)) {
    board_.append(Series::history, framed(json_text(*bin)));
  }
  wavefront_at_ = Clock::now();
  const bool valid = wavefront.at("valid").get<bool>();
  if (valid) valid_at_ = wavefront_at_;
  if (!valid && wavefront_at_ - valid_at_ <= kValidHold) return;
  board_.put(Slot::wavefront, framed(message.json));
  facts_.wavefront = std::move(wavefront);
}

void Feeds::take_status(const StreamMessage& message) {
  json status = json_of(message.json);
  const double t_s = seconds(Clock::now().time_since_epoch());
  lost_.add(t_s, status.at("counters").at("frames_lost").get<std::int64_t>());
  missed_.add(t_s, status.at("counters").at("deadline_missed").get<std::int64_t>());
  facts_.slow_statuses = slow_camera(status) ? facts_.slow_statuses + 1 : 0;
  for (const char* part : {"slm", "camera", "sensor", "loop"}) {
    if (!facts_.status || (*facts_.status)[part] != status[part]) ++hologram_change_;
  }
  board_.put(Slot::status, framed(message.json));
  facts_.status = std::move(status);
  status_at_ = Clock::now();
}

void Feeds::take_spots(const StreamMessage& message) {
  const auto frame_id = json_of(message.json)["frame_id"].get<std::uint64_t>();
  std::string packet = framed(message.json, message.binary);
  const Clock::duration last_image(last_image_.load());
  if (Clock::now().time_since_epoch() - last_image > kSilence) board_.put(Slot::spots, packet);
  spots_.add(frame_id, std::move(packet));
}

void Feeds::take_image(StreamMessage message) {
  const auto image = reduced_image(message);
  if (!image) return;
  const json header = json_of(image->json);
  const bool whole = header["reduced_by"] == 1;
  image_.set(whole ? nullptr : std::make_shared<const StreamMessage>(std::move(message)));
  const auto frame_id = header["frame_id"].get<std::uint64_t>();
  if (auto spots = spots_.of_frame(frame_id)) board_.put(Slot::spots, std::move(*spots));
  board_.put(Slot::image, framed(image->json, image->binary));
  last_image_ = Clock::now().time_since_epoch().count();
}

void Feeds::publish_health() {
  const auto now = Clock::now();
  if (now - health_at_ < kHealthPeriod) return;
  health_at_ = now;
  facts_.status_age_s = seconds(now - status_at_);
  facts_.wavefront_age_s = seconds(now - wavefront_at_);
  facts_.lost_lately = lost_.rise();
  facts_.missed_lately = missed_.rise();
  const ServerFacts server = server_facts_();
  json health{{"schema", "ovws.web.health/1"},
              {"t_ns", utc_ns()},
              {"findings", json::array()},
              {"browsers", server.browsers},
              {"refused", server.refused}};
  try {
    for (const examine::Finding& one : examine::page_findings(facts_)) {
      health["findings"].push_back({{"wellness", examine::names_of(one.severity).name},
                                    {"text", one.text},
                                    {"action", one.action}});
    }
  } catch (const json::exception& error) {
    spdlog::warn(
        "a status of the daemon has an unknown format, which another version may have: install the "
        "same version of both ({})",
        error.what());
  }
  board_.put(Slot::health, framed(json_text(health)));
}

}  // namespace ovws::web
