/// Publisher on a ZeroMQ PUB socket. Sending never blocks: a full queue drops messages.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// Publisher of multipart messages. Use it from one thread at a time.
class Publisher {
 public:
  /// Binds the socket. Up to `send_queue` messages wait for each subscriber; a slow subscriber
  /// loses only its own messages. With a gate, only clients that the gate accepts can subscribe,
  /// over CURVE. Errors: Errc::unavailable (endpoint in use), Errc::invalid (malformed endpoint);
  /// both errors name the endpoint.
  static Result<Publisher> bind(const std::string& endpoint, int send_queue, Gate* gate = nullptr);

  /// Sends the frames [topic][json], and [binary] if it is not empty. False if the message was not
  /// sent: this process's own queue was full, or the socket is being rebound (Gate::end_streams).
  bool send(std::string_view topic, std::string_view json, std::span<const std::byte> binary = {});

 private:
  struct Impl;
  explicit Publisher(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
