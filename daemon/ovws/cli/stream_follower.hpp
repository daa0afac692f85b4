/// A daemon's stream through its restarts.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Subscribes as soon as the daemon says where its stream is. While nothing comes it asks again,
/// for a daemon may come back with another address. One thread.
class StreamFollower {
 public:
  /// `patience`: how long an answer to that question may take, which holds up receive.
  StreamFollower(const Common& common, std::vector<std::string> topics,
                 std::chrono::milliseconds patience);

  /// The next message; none if none came in time.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;
  void look_for_daemon();

  Common common_;
  std::vector<std::string> topics_;
  std::string endpoint_;  ///< empty: not known yet
  std::optional<Subscriber> stream_;
  Clock::time_point next_look_{};
};

}  // namespace ovws::cli
