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

/// Client of the control socket. Use it from one thread at a time.
class ControlClient {
 public:
  /// Connects to the daemon, with CURVE keys if `keys` is given. Errors: Errc::invalid (malformed
  /// endpoint or keys). If no daemon runs or it rejects the keys, the first request reports the
  /// error.
  static Result<ControlClient> connect(const std::string& endpoint,
                                       const std::optional<ClientKeys>& keys = std::nullopt);

  /// Sends one request and waits for its reply, whose binary frame goes to `binary`, if given.
  /// Errors: Errc::unavailable if no reply arrives within `timeout`; Errc::refused at once, with
  /// the reason, if the daemon rejects this client. A late reply to an earlier request is never
  /// returned.
  Result<std::string> request(std::string_view bytes, std::chrono::milliseconds timeout,
                              std::vector<std::byte>* binary = nullptr);

 private:
  struct Impl;
  explicit ControlClient(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

struct StreamMessage {
  std::string topic;
  std::string json;
  std::vector<std::byte> binary;  ///< binary part; empty if the topic has none
};

/// Subscriber of the daemon's streams. Use it from one thread at a time.
class Subscriber {
 public:
  /// Connects and subscribes to `topics`, exactly these; an empty list means all topics. Up to
  /// `receive_queue` messages are queued for a slow caller; further messages are lost. Errors: as
  /// in ControlClient::connect.
  static Result<Subscriber> connect(const std::string& endpoint,
                                    const std::vector<std::string>& topics, int receive_queue,
                                    const std::optional<ClientKeys>& keys = std::nullopt);

  /// Returns the next message. None on time-out, if a signal interrupted the wait, or if the
  /// message is not one of ovwsd.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit Subscriber(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
