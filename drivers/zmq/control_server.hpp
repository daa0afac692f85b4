/// A ROUTER socket for requests: any REQ or DEALER, exactly one reply a request, from any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.hpp"
#include "core/rt/agent.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// Takes the request's bytes, the public key of who asks (empty without a gate) and a function to
/// call once with the reply's bytes, from any thread, at any time (also after the server is gone:
/// then it does nothing). An empty reply sends nothing.
using ControlHandler = std::function<void(std::string_view request, const std::string& asker,
                                          std::function<void(std::string)> reply)>;

struct ControlLimits {
  std::size_t max_request_bytes = 0;
  std::string oversize_reply;  ///< to larger requests, and to those of several frames
  std::string overload_reply;  ///< to a request that comes while too many of its client wait
};

/// `do_work` runs in the control thread: it waits for requests and for replies to send, at most 50
/// ms.
class ControlServer : public Agent {
 public:
  /// Requests that `limits` refuse are answered and not handed on (above 2 MiB libzmq ends the
  /// connection). Clients are served in turn, one request each; those of one client in their
  /// order. A client's next request waits while 64 of its requests or 8 KiB of them are being
  /// carried out, or 128 of its replies or 4 MiB of them are unread. Up to 8 MiB of requests wait
  /// for each client, 32 MiB for all. A client that leaves the replies beyond that unread loses
  /// some. With a gate this server turns it, for all sockets behind it; bind it last. Errors as of
  /// Publisher::bind.
  static Result<std::unique_ptr<ControlServer>> bind(const std::string& endpoint,
                                                     ControlLimits limits, ControlHandler handler,
                                                     Gate* gate = nullptr);
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;
  ~ControlServer() override;
  bool do_work() override;
  /// Sends the replies that are there.
  void on_close() override;

 private:
  struct Impl;
  explicit ControlServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
