/// A PUB socket: multipart messages, small queues, never waits.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// One thread at a time.
class Publisher {
 public:
  /// `send_queue` messages per subscriber; a slow one loses its own. Errors: Errc::unavailable
  /// (port in use, said with the endpoint), Errc::invalid (endpoint not understood). With a gate:
  /// only clients that it lets in, over CURVE.
  static Result<Publisher> bind(const std::string& endpoint, int send_queue, Gate* gate = nullptr);
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;
  Publisher(Publisher&&) noexcept;
  Publisher& operator=(Publisher&&) noexcept;
  ~Publisher();

  /// [topic][json][binary, if not empty]. False if this process's own queue was full, or the
  /// socket is just being bound anew (Gate::end_streams).
  bool send(std::string_view topic, std::string_view json, std::span<const std::byte> binary = {});

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
