/// Subscriber that reconnects when the daemon restarts.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Asks the daemon for its stream's endpoint and subscribes. While no message arrives it asks
/// again, because a restarted daemon may use another endpoint. One thread.
class StreamFollower {
 public:
  /// `call_timeout`: timeout of the request for the endpoint; receive blocks for that long in
  /// addition.
  StreamFollower(const Common& common, std::vector<std::string> topics,
                 std::chrono::milliseconds call_timeout);

  /// The next message; none if none arrives within `timeout`.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;
  void request_endpoint();

  Common common_;
  std::vector<std::string> topics_;
  std::string endpoint_;  ///< empty: not yet known
  std::optional<Subscriber> stream_;
  Clock::time_point next_request_{};
};

}  // namespace ovws::cli
