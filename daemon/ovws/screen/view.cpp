#include "daemon/ovws/screen/view.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "daemon/ovws/text/losses.hpp"
#include "proto/json_text.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;

constexpr double kStatusMaxAgeS = 3.0;  ///< an older status is stale; the period is one second
constexpr double kMaxAgeFrames = 3.0;
constexpr std::size_t kEventsKept = 50;
constexpr std::size_t kSpotColumns = 6;
double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

json read(const std::string& text) {
  json message = json_of(text);
  return message.is_object() ? message : json();
}

}  // namespace

void Gatherer::take(const std::string& topic, std::string text, std::vector<std::byte> binary,
                    Clock::time_point now) {
  last_ = now;
  if (topic == "wavefront") {
    wavefront_ = std::move(text);
    last_frame_ = now;
  } else if (topic == "spots") {
    spots_ = std::move(text);
    spots_binary_ = std::move(binary);
  } else if (topic == "status") {
    json status = read(text);
    if (!status.is_object()) return;
    read_status(std::move(status));
    last_status_ = now;
  } else if (topic == "event") {
    if (json event = read(text); event.is_object()) view_.events.push_back(std::move(event));
    if (view_.events.size() > kEventsKept) view_.events.pop_front();
  }
}

void Gatherer::read_status(json status) {
  view_.status = std::move(status);
  view_.losses.clear();
  if (!view_.status.contains("counters") || !view_.status.at("counters").is_object()) return;
  std::map<std::string, std::uint64_t> counters;
  for (const auto& [name, count] : view_.status.at("counters").items()) {
    if (count.is_number_unsigned()) counters[name] = count.get<std::uint64_t>();
  }
  for (const std::string_view loss : cli::kLosses) {
    const std::string name(loss);
    const std::uint64_t count = counters.contains(name) ? counters[name] : 0;
    // A restarted daemon counts from 0 again.
    const std::uint64_t before = counters_.contains(name) ? counters_[name] : count;
    if (count > 0) view_.losses.push_back({name, count, count - std::min(before, count)});
  }
  counters_ = std::move(counters);
}

void Gatherer::read_wavefront() {
  if (wavefront_.empty()) return;
  view_.wavefront = read(wavefront_);
  wavefront_.clear();
}

void Gatherer::read_spots() {
  if (spots_.empty()) return;
  spots_.clear();
  constexpr std::size_t kRowBytes = kSpotColumns * sizeof(float);
  view_.spots.clear();
  for (std::size_t at = 0; at + kRowBytes <= spots_binary_.size(); at += kRowBytes) {
    float row[kSpotColumns];
    std::memcpy(row, spots_binary_.data() + at, kRowBytes);
    view_.spots.push_back({row[0], row[1], row[2], row[3]});
  }
}

bool Gatherer::frames_are_current(Clock::time_point now) const {
  if (!last_frame_) return false;
  const json::json_pointer path("/camera/settings/frame_rate_hz");
  const bool has_rate = view_.status.contains(path) && view_.status.at(path).is_number();
  const double rate_hz = has_rate ? view_.status.at(path).get<double>() : 1.0;
  return seconds(now - *last_frame_) <
         std::max(kStatusMaxAgeS, kMaxAgeFrames / std::max(rate_hz, 1e-6));
}

const View& Gatherer::view(Clock::time_point now) {
  view_.status_is_current = last_status_ && seconds(now - *last_status_) < kStatusMaxAgeS;
  view_.silent_s = seconds(now - last_);
  if (!view_.status_is_current) {
    view_.status = json();
    view_.losses.clear();
  }
  read_wavefront();
  read_spots();
  if (!view_.status_is_current || !frames_are_current(now)) {
    view_.wavefront = json();
    view_.spots.clear();
  }
  return view_;
}

}  // namespace ovws::screen
