/// How old the newest message of a stream may be, so that stale values do not look live.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>

#include "proto/json_part.hpp"

namespace ovws {

constexpr double kStatusMaxAgeS = 3.0;  ///< `status` is published every second

/// Oldest `wavefront` that counts, seconds: some frames at the camera's rate. `status`: the newest.
inline double wavefront_max_age_s(const nlohmann::json& status) {
  constexpr double kMaxAgeFrames = 3.0;
  const double rate_hz = number_at(status, "/camera/settings/frame_rate_hz").value_or(1.0);
  return std::max(kStatusMaxAgeS, kMaxAgeFrames / std::max(rate_hz, 1e-6));
}

}  // namespace ovws
