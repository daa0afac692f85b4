#include "daemon/ovws/cli/replay_tally.hpp"

#include "daemon/shared/client.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {

using nlohmann::json;

json text_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json(text);
}

void ReplayTally::count(const json& line) {
  const bool was_replayed = line.at("replayed").get<bool>(), is_same = line.at("same").get<bool>();
  ++frames;
  replayed += was_replayed;
  same += is_same;
  valid += line.at("valid").get<bool>();
  const json& fit = line.value("refined", json());
  refined += fit.is_object() && fit.at("valid").get<bool>();
  const std::string id = "frame " + json_text(line.at("frame_id"));
  if (!was_replayed && first_reason.empty()) {
    first_reason = id + ": " + line.at("reason").get<std::string>();
  }
  if (was_replayed && !is_same && first_difference.empty()) first_difference = id;
}

json ReplayTally::content() const {
  return {{"frames", frames},
          {"replayed", replayed},
          {"same", same},
          {"valid", valid},
          {"refined", refined},
          {"first_not_replayed", text_or_null(first_reason)},
          {"first_difference", text_or_null(first_difference)}};
}

void ReplayTally::print_text(const std::string& name) const {
  print("{}: {} frames, {} replayed, {} of them bit for bit the same, {} valid\n", name, frames,
        replayed, same, valid);
  if (refined > 0) print("{} refined\n", refined);
  if (!first_reason.empty()) print("first not replayed: {}\n", first_reason);
  if (!first_difference.empty()) print("first difference: {}\n", first_difference);
}

}  // namespace ovws::cli
