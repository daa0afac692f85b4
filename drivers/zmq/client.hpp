/// Client of the daemon's sockets: requests with a time-out, and stream subscriptions.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "drivers/zmq/curve.hpp"

namespace ovws {

/// Client of the control socket. One thread at a time.
class ControlClient {
 public:
  /// Connects, without keys to a daemon that requires none. Errors: Errc::invalid (malformed
  /// endpoint or keys). A missing daemon or rejected keys are reported by the first request.
  static Result<ControlClient> connect(const std::string& endpoint,
                                       const std::optional<ClientKeys>& keys = std::nullopt);

  /// Sends one request and waits for its reply. Errors: Errc::unavailable if none came in time;
  /// Errc::refused at once, with the reason, if the daemon rejects this client. A late reply is
  /// never taken for that of another request.
  Result<std::string> request(std::string_view bytes, std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit ControlClient(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

struct StreamMessage {
  std::string topic;
  std::string json;
  std::vector<std::byte> binary;  ///< empty if the topic has none
};

/// Subscriber of the daemon's streams. One thread at a time.
class Subscriber {
 public:
  /// Connects and subscribes. `topics`: empty means all. Up to `receive_queue` messages are queued
  /// for a slow reader; further ones are lost. Errors as in ControlClient::connect.
  static Result<Subscriber> connect(const std::string& endpoint,
                                    const std::vector<std::string>& topics, int receive_queue,
                                    const std::optional<ClientKeys>& keys = std::nullopt);

  /// The next message. None on time-out, or if a signal interrupted the wait.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit Subscriber(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
