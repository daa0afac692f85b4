/// What the streams do not tell and a browser wants to know: the camera's limits, what is
/// introduced and corrected, the loop, the reference, the hologram's picture.
#pragma once

#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "daemon/shared/client.hpp"
#include "daemon/web/hologram_picture.hpp"

namespace ovws::web {

class BenchView {
 public:
  explicit BenchView(const cli::Common& common) : common_(common) {}

  /// Asks the daemon; the message for a browser, or none if the daemon did not answer all of it, or
  /// nothing is new. One thread.
  std::optional<nlohmann::json> look(const std::string& pattern);

  /// The newest; null: there is none yet. Thread-safe.
  HologramPicturePtr hologram() const;

 private:
  using Clock = std::chrono::steady_clock;

  /// "crc32" and "hologram_id" of its picture, or why there is none.
  nlohmann::json hologram_of(const HologramSources& sources);

  const cli::Common& common_;
  HologramSources drawn_;
  Clock::time_point drawn_at_{};
  nlohmann::json last_;
  mutable std::mutex mutex_;
  HologramPicturePtr hologram_;
};

}  // namespace ovws::web
