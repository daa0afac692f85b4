/// Control server on a ROUTER socket, for REQ and DEALER clients. Each request gets one reply,
/// which any thread may give.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "core/rt/agent.hpp"
#include "drivers/zmq/gate.hpp"
#include "drivers/zmq/send_reply.hpp"

namespace ovws {

/// One request: its frame, the binary frame that may follow it (empty: none), and the client's
/// public key (empty without a gate).
struct ControlRequest {
  std::string bytes;
  std::string binary;
  std::string client_key;
};
/// Handles one request. Call `reply` once, from any thread; an empty reply sends nothing. After the
/// server is destroyed, `reply` does nothing.
using ControlHandler = std::function<void(ControlRequest request, SendReply reply)>;

struct ControlLimits {
  std::size_t max_request_bytes = 0;
  std::size_t max_binary_bytes = 0;  ///< 0: requests have no binary frame
  std::string oversize_reply;        ///< reply to a request that is too large or has more frames
  std::string overload_reply;        ///< reply to a request that cannot be queued
};

/// Agent of the control thread. Each `do_work` waits at most 50 ms for requests or for replies to
/// send.
class ControlServer : public Agent {
 public:
  /// Binds the server. Requests that exceed `limits` are answered without calling the handler;
  /// frames above 2 MiB (or the largest binary frame) make libzmq close the connection. Clients are
  /// served round-robin, one request per turn, each client's requests in order. A client's next
  /// request waits while 64 of its requests (or 8 KiB) are being carried out, or 128 of its replies
  /// (or 4 MiB) are unread. A request with a binary frame also waits while 32 MiB of requests of
  /// all clients are being carried out. Up to 8 MiB of requests are queued per client, 32 MiB in
  /// total, or one request of any size; requests beyond these limits get `overload_reply`, or no
  /// reply while 1024 replies of the client or 16384 in total are unread. A TCP client that has
  /// replies and reads nothing for 60 s is disconnected. With a gate, this server checks the keys
  /// for all sockets bound with the gate; bind this server last. Errors as in Publisher::bind.
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
