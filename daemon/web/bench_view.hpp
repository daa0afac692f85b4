/// Bench data that no stream publishes: camera limits, introduced aberration, correction, loop,
/// reference and the hologram's image. Polled from the daemon for the browsers.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/shared/client.hpp"
#include "daemon/shared/guarded.hpp"
#include "daemon/web/hologram_image.hpp"

namespace ovws::web {

class BenchView {
 public:
  explicit BenchView(const cli::Common& common) : common_(common) {}

  /// Queries the daemon and returns the message for browsers. `jobs`: a number that changes when a
  /// job or a command may have changed what was measured. None if a query failed or nothing
  /// changed. Call from one thread only.
  std::optional<nlohmann::json> look(std::int64_t jobs);

  /// Newest hologram image. Null if no image was drawn yet, or if the current hologram cannot be
  /// drawn; the message of `look` then gives the reason. Thread-safe.
  HologramImagePtr hologram() const { return hologram_.get(); }

 private:
  using Clock = std::chrono::steady_clock;

  /// {"hologram_id", "crc32", "reason"} of the hologram image; "reason" says why there is no image.
  nlohmann::json hologram_of(const HologramSources& sources);

  /// The last answer to a query that may wait, or costs the daemon more than others.
  struct Seldom {
    nlohmann::json answer = nlohmann::json::object();
    std::int64_t jobs = -1;
    Clock::time_point at{};
  };
  /// Asks again after a job or a command, and seldom otherwise. Without an answer it stays.
  const nlohmann::json& seldom(Seldom& kept, const char* method, std::int64_t jobs);

  const cli::Common& common_;
  Seldom calibration_, references_;
  HologramSources drawn_;
  Clock::time_point drawn_at_{};
  nlohmann::json last_;
  Guarded<HologramImagePtr> hologram_;
};

}  // namespace ovws::web
