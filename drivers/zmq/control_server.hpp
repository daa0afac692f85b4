/// A ROUTER socket for requests: any REQ or DEALER, exactly one reply a request, from any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.hpp"
#include "core/rt/agent.hpp"

namespace ovws {

/// Takes the request's bytes and a function to call once with the reply's bytes, from any thread,
/// at any time (also after the server is gone: then it does nothing). An empty reply sends nothing.
using ControlHandler =
    std::function<void(std::string_view request, std::function<void(std::string)> reply)>;

/// `do_work` runs in the control thread: it waits for requests and for replies to send, at most 50
/// ms.
class ControlServer : public Agent {
 public:
  /// `max_request_bytes`: larger requests are answered by `oversize_reply` and never held in memory
  /// (ZMQ_MAXMSGSIZE closes far larger ones).
  static Result<std::unique_ptr<ControlServer>> bind(const std::string& endpoint,
                                                     std::size_t max_request_bytes,
                                                     std::string oversize_reply,
                                                     ControlHandler handler);
  ~ControlServer() override;
  bool do_work() override;

 private:
  struct Impl;
  explicit ControlServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
