/// The state of the bench in reading order.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovws::cli {

/// What `ovws status` shows: results of system.status, camera.get, … and the newest frame.
struct BenchState {
  nlohmann::json status, loop, aberration, correction, reference;
  nlohmann::json wavefront;  ///< newest wavefront message; null: none came
  std::string not_valid;     ///< why its frame is not valid; empty: it is
};

/// One line per subject, with its name in the first 11 columns, ending with a newline. Throws
/// nlohmann::json::exception if a part is not one of this version of the daemon.
std::string status_text(const BenchState& bench);

/// Frames per second that the camera sends, by system.status; with what limits them and what to do
/// if they are fewer than it is set to.
std::string measured_rate_text(const nlohmann::json& status);
/// The largest of the correction's modes, and how to remove it unless the loop is closed; empty:
/// there is no correction. `modes` of correction.get, and loop.get.
std::string correction_text(const nlohmann::json& modes, const nlohmann::json& loop);

}  // namespace ovws::cli
