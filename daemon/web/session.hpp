/// One HTTP connection: a request and its response.
#pragma once

#include <optional>
#include <string>

#include "daemon/web/commands.hpp"
#include "daemon/web/http.hpp"
#include "daemon/web/server.hpp"

namespace ovws::web {

/// State of one connection; lives as long as its coroutine.
class Session {
 public:
  /// `callers`: threads for calls to the daemon.
  Session(tcp::socket socket, const ServerParts& parts, net::thread_pool& callers);

  /// Serves the request. Connection errors close the connection and are not reported.
  Task<void> run();
  /// Whether the request had a valid token.
  bool trusted() const { return trusted_; }
  /// Closes the connection; `run` returns soon.
  void end() { connection_.close(); }

 private:
  using Request = http::request_parser<http::string_body>;

  Task<void> serve();
  /// Reads the request header. False if the request is malformed (then it was answered) or if the
  /// browser has disconnected.
  Task<bool> read_head(Request& parser);
  Task<void> answer(http::status status, std::string_view type, std::string body);
  Task<void> refuse(Refusal why, const RequestHead& head);
  Task<void> stream(const RequestHead& head, Right right);
  Task<void> pump(Right right);
  /// Carries out a command in a thread of the pool, first come, first served. None if the browser
  /// disconnects first; a call that has not begun is then dropped.
  Task<std::optional<std::string>> reply_to(const Command& command);
  Task<void> rpc(Request& parser, const RequestHead& head);
  Task<void> hologram();

  ServerParts parts_;
  net::thread_pool& callers_;
  beast::tcp_stream connection_;
  beast::flat_buffer buffer_;
  std::string peer_;
  bool trusted_ = false;
};

}  // namespace ovws::web
