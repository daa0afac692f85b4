/// Subscriber that finds the daemon again when it restarts.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Asks the daemon for its stream's endpoint and subscribes. While no message arrives it does so
/// again: a restarted daemon may use another endpoint, and libzmq does not repeat a connection that
/// was rejected. One thread at a time.
class StreamFollower {
 public:
  /// `key`: of the endpoint, as for stream_endpoint; `queue`: messages kept between two calls of
  /// receive. A request for the endpoint takes at most `common.timeout_s`, and receive blocks for
  /// that long in addition.
  StreamFollower(Common common, const char* key, std::vector<std::string> topics, int queue);

  /// The next message; none if none arrives within `timeout`.
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
