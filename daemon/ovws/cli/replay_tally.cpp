#include "daemon/ovws/cli/replay_tally.hpp"

#include "daemon/ovws/text/fill.hpp"
#include "proto/json_part.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {

using nlohmann::json;

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

std::string ReplayTally::text(const std::string& name) const {
  json said = content();
  said["name"] = name;
  return fill(
      "{name}: {frames} frames, {replayed} replayed, {same} of them bit for bit the same, {valid} "
      "valid[refined?\n{refined} refined][first_not_replayed?\nfirst not replayed: "
      "{first_not_replayed}][first_difference?\nfirst difference: {first_difference}]",
      said);
}

}  // namespace ovws::cli
