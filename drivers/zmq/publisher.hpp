/// Publisher on a PUB socket: multipart messages, short queues, never blocks.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// One thread at a time.
class Publisher {
 public:
  /// Binds the socket. `send_queue` messages per subscriber; a slow subscriber loses only its own.
  /// With a gate, only clients that it accepts can subscribe, over CURVE. Errors: Errc::unavailable
  /// (endpoint in use), Errc::invalid (malformed endpoint); both name the endpoint.
  static Result<Publisher> bind(const std::string& endpoint, int send_queue, Gate* gate = nullptr);

  /// Sends [topic][json][binary, if not empty]. False if this process's own queue was full, or the
  /// socket is being rebound (Gate::end_streams).
  bool send(std::string_view topic, std::string_view json, std::span<const std::byte> binary = {});

 private:
  struct Impl;
  explicit Publisher(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
