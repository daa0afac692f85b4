/// Subscriber that finds the daemon again when it restarts.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

constexpr int kStreamQueue = 1000;  ///< messages, for a StreamFollower

/// Subscriber that asks the daemon for the stream's endpoint. While no message arrives, it asks and
/// subscribes again: a restarted daemon may use another endpoint, and libzmq does not retry a
/// rejected connection. Use it from one thread at a time.
class StreamFollower {
 public:
  /// `key` selects the endpoint, as for open_stream. `queue`: messages kept between two calls
  /// of `receive`. `receive` may block for `common.timeout_s` longer while it asks for the
  /// endpoint.
  StreamFollower(Common common, const char* key, std::vector<std::string> topics, int queue);

  /// Returns the next message; none if no message arrives within `timeout`.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;
  void subscribe_again();

  Common common_;
  const char* key_;
  std::vector<std::string> topics_;
  int queue_;
  std::optional<Subscriber> stream_;
  Clock::time_point next_request_{};
};

}  // namespace ovws::cli
