#include "daemon/ovws/screen/view.hpp"

#include <algorithm>
#include <utility>

#include "core/rt/counters.hpp"
#include "proto/json_text.hpp"
#include "proto/message_age.hpp"

namespace ovws::screen {
namespace {

using nlohmann::json;

constexpr std::size_t kEventsKept = 50;

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
    spots_ = std::move(binary);
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
  for (const CounterRow& row : all_counters()) {
    const std::string name(row.name);
    const std::uint64_t count = counters.contains(name) ? counters[name] : 0;
    // A restarted daemon counts from 0 again.
    const std::uint64_t before = counters_.contains(name) ? counters_[name] : count;
    if (row.is_loss && count > 0)
      view_.losses.push_back({name, count, count - std::min(before, count)});
  }
  counters_ = std::move(counters);
}

void Gatherer::read_wavefront() {
  if (wavefront_.empty()) return;
  view_.wavefront = read(wavefront_);
  wavefront_.clear();
}

bool Gatherer::frames_are_current(Clock::time_point now) const {
  return last_frame_ && seconds(now - *last_frame_) < wavefront_max_age_s(view_.status);
}

const View& Gatherer::view(Clock::time_point now) {
  view_.status_is_current = last_status_ && seconds(now - *last_status_) < kStatusMaxAgeS;
  view_.silent_s = seconds(now - last_);
  if (!view_.status_is_current) {
    view_.status = json();
    view_.losses.clear();
  }
  read_wavefront();
  view_.spots = spot_rows(spots_);
  if (!view_.status_is_current || !frames_are_current(now)) {
    view_.wavefront = json();
    view_.spots.clear();
  }
  return view_;
}

}  // namespace ovws::screen
