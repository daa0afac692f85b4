/// One HTTP connection: a request and its response.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "daemon/web/commands.hpp"
#include "daemon/web/http.hpp"
#include "daemon/web/server.hpp"

namespace ovws::web {

/// Scope guard that increments a counter.
class Counted {
 public:
  explicit Counted(std::atomic<int>& count) : count_(count) { ++count_; }
  ~Counted() { --count_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::atomic<int>& count_;
};

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

  /// Sets the fields that all responses have.
  static void prepare(http::fields& header, std::string_view type);
  Task<void> serve();
  /// Reads the request header. False if the request is malformed (then it was answered) or if the
  /// browser has disconnected.
  Task<bool> read_head(Request& parser);
  Task<void> answer(http::status status, std::string_view type, std::string body);
  /// Without a body: there is no content.
  Task<void> answer(std::string_view type, std::string body);
  Task<void> refuse(Refusal why, const RequestHead& head);
  Task<void> stream(const RequestHead& head, Right right);
  Task<void> pump(Right right);
  /// Answers with the result of work that may block, done in a thread of the pool. The browser may
  /// take `patience` to receive it.
  Task<void> answer_from_pool(std::string_view type, std::function<std::string()> work,
                              std::chrono::milliseconds patience);
  Task<void> rpc(Request& parser, const RequestHead& head);
  Task<void> hologram();
  Task<void> commission_action(Request& parser, const RequestHead& head);
  Task<void> commission_picture(const RequestHead& head);
  Task<void> image(const RequestHead& head);

  // In download.cpp.
  using Opened = Result<std::shared_ptr<const OpenRecording>>;
  Task<std::optional<Opened>> open(const std::string& name);
  Task<void> recordings();
  Task<void> ticket(Request& parser, const RequestHead& head);
  Task<void> recording(const RequestHead& head, Right right);
  Task<void> send(const std::shared_ptr<const OpenRecording>& file);

  ServerParts parts_;
  net::thread_pool& callers_;
  beast::tcp_stream connection_;
  beast::flat_buffer buffer_;
  std::string peer_;
  bool trusted_ = false;
};

}  // namespace ovws::web
