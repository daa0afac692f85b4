/// Control server: a ROUTER socket for any REQ or DEALER client; exactly one reply per request,
/// from any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "core/rt/agent.hpp"
#include "drivers/zmq/gate.hpp"

namespace ovws {

/// Handles one request: its bytes, the client's public key (empty without a gate), and a function
/// to call once with the reply's bytes. The function may be called from any thread at any time;
/// after the server is gone it does nothing. An empty reply sends nothing.
using ControlHandler = std::function<void(std::string_view request, const std::string& client_key,
                                          std::function<void(std::string)> reply)>;

struct ControlLimits {
  std::size_t max_request_bytes = 0;
  std::string oversize_reply;  ///< for larger requests, and those of several frames
  std::string overload_reply;  ///< for a request while too many of its client wait
};

/// `do_work` runs in the control thread: it waits at most 50 ms for requests and for replies to
/// send.
class ControlServer : public Agent {
 public:
  /// Binds the server. Requests beyond `limits` are answered without calling the handler; above 2
  /// MiB libzmq closes the connection. Clients are served round-robin, one request each, those of
  /// one client in order. A client's next request waits while 64 of its requests or 8 KiB of them
  /// are being carried out, or 128 of its replies or 4 MiB of them are unread. Up to 8 MiB of
  /// requests are queued for each client, 32 MiB for all; further ones get `overload_reply`, and a
  /// client that leaves those unread, too, loses some. With a gate, this server runs the gate for
  /// all sockets behind it; bind it last. Errors as in Publisher::bind.
  static Result<std::unique_ptr<ControlServer>> bind(const std::string& endpoint,
                                                     ControlLimits limits, ControlHandler handler,
                                                     Gate* gate = nullptr);
  bool do_work() override;
  /// Sends the pending replies.
  void on_close() override;

 private:
  struct Impl;
  explicit ControlServer(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
