/// A camera that sends fewer frames than it is set to: when it counts as slow, and what limits it.
#pragma once

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "proto/json_part.hpp"

namespace ovws {

struct SlowCamera {
  double measured_hz = 0.0, expected_hz = 0.0;
  double exposure_us = 0.0;

  /// Whether the exposure fills the time between the frames that come.
  bool is_slowed_by_exposure() const {
    constexpr double kLeastShare = 0.8;
    return 1e-6 * exposure_us * measured_hz >= kLeastShare;
  }
  /// What limits the rate, as far as it is known, and what to do; `examine`: how to examine the
  /// bench, in the reader's words.
  std::string advice(const std::string& examine) const {
    if (is_slowed_by_exposure()) {
      return "the exposure fills the time between frames: shorten it, or lower the frame rate";
    }
    return "the exposure leaves time for more: check the camera's link and limits (" + examine +
           "), or lower the frame rate";
  }
};

/// A frame rate in four digits and never with an exponent, as `ovws rate` accepts it.
inline std::string hz_text(double hz) {
  return hz < 1000.0 ? fmt::format("{:.4g}", hz) : fmt::format("{:.0f}", hz);
}

/// Whether this `status` shows a slow camera. None if `rates.expected_hz` is null (a triggered
/// camera, a job, new settings), and without frames, which is another fault. Of the frames of about
/// a second two may be missing by chance.
inline std::optional<SlowCamera> slow_camera(const nlohmann::json& status) {
  constexpr double kUsualShare = 0.9, kByChanceHz = 2.0;
  const auto expected_hz = number_at(status, "/rates/expected_hz");
  const double measured_hz = number_at(status, "/rates/grabbed_hz").value_or(0.0);
  const bool is_slow =
      expected_hz && measured_hz > 0.0 && measured_hz < kUsualShare * *expected_hz - kByChanceHz;
  if (!is_slow) return std::nullopt;
  return SlowCamera{measured_hz, *expected_hz,
                    number_at(status, "/camera/settings/exposure_us").value_or(0.0)};
}

}  // namespace ovws
