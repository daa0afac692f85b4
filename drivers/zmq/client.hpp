/// The other side of the daemon's sockets: requests with a time-out, and received streams.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/zmq/curve.hpp"

namespace ovws {

/// One thread at a time.
class ControlClient {
 public:
  /// Without keys: to a daemon that asks for none. Errors: Errc::invalid (endpoint or keys not
  /// understood). That nobody is there, or that the keys are wrong, shows with the first request.
  static Result<ControlClient> connect(const std::string& endpoint,
                                       const std::optional<ClientKeys>& keys = std::nullopt);
  ControlClient(const ControlClient&) = delete;
  ControlClient& operator=(const ControlClient&) = delete;
  ControlClient(ControlClient&&) noexcept;
  ControlClient& operator=(ControlClient&&) noexcept;
  ~ControlClient();

  /// Sends one request and waits for its reply. Errors: Errc::unavailable if none came in time, or
  /// Errc::refused at once if the daemon does not let this client in, and why; a reply that comes
  /// later is never taken for that of another request.
  Result<std::string> request(std::string_view bytes, std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit ControlClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct StreamMessage {
  std::string topic;
  std::string json;
  std::vector<std::byte> binary;  ///< empty if the topic has none
};

/// One thread at a time.
class Subscriber {
 public:
  /// `topics`: empty means all. `receive_queue` messages are kept for a slow reader, then the
  /// newest are lost.
  static Result<Subscriber> connect(const std::string& endpoint,
                                    const std::vector<std::string>& topics, int receive_queue,
                                    const std::optional<ClientKeys>& keys = std::nullopt);
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;
  Subscriber(Subscriber&&) noexcept;
  Subscriber& operator=(Subscriber&&) noexcept;
  ~Subscriber();

  /// None if nothing came in time, or a signal came first.
  std::optional<StreamMessage> receive(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit Subscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
