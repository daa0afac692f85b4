#include "daemon/web/session.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <limits>

#include "daemon/web/in_pool.hpp"
#include "daemon/web/page_files.hpp"
#include "proto/json_text.hpp"

namespace ovws::web {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMaxHeadBytes = 8 * 1024;
constexpr milliseconds kRequestTimeout{5000};
constexpr milliseconds kWriteTimeout{10'000};
/// For messages: a page that computes, or whose computer sleeps for a moment, does not read.
constexpr milliseconds kStreamTimeout{60'000};
constexpr milliseconds kPollInterval{5};   ///< polls the board
constexpr milliseconds kSendInterval{33};  ///< minimum interval of messages to a browser
/// Socket send buffer. Small, because messages that wait there for a slow browser become stale.
constexpr int kSendBufferBytes = 256 * 1024;

/// Content Security Policy: only resources of this server, and no embedding in frames.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

// Pass only locals to co_await, never owning temporaries: g++ 12 destroys some temporaries twice.

RequestHead head_of(const http::request_parser<http::string_body>& parser) {
  const auto& request = parser.get();
  const auto text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
  RequestHead head;
  head.method = text(request.method_string());
  head.target = text(request.target());
  head.host = text(request[http::field::host]);
  head.origin = text(request[http::field::origin]);
  head.fetch_site = text(request["Sec-Fetch-Site"]);
  head.authorization = text(request[http::field::authorization]);
  head.chunked = request.chunked();
  if (const auto length = parser.content_length()) head.content_length = *length;
  return head;
}

}  // namespace

void Session::prepare(http::fields& header, std::string_view type) {
  header.set(http::field::connection, "close");
  header.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  header.set("Content-Security-Policy", kContentPolicy);
  header.set("X-Content-Type-Options", "nosniff");
  header.set("Referrer-Policy", "no-referrer");
  header.set("Cross-Origin-Resource-Policy", "same-origin");
  header.set("Cross-Origin-Opener-Policy", "same-origin");
  header.set(http::field::cache_control, "no-store");
}

Session::Session(tcp::socket socket, const ServerParts& parts, net::thread_pool& callers)
    : parts_(parts),
      callers_(callers),
      connection_(std::move(socket)),
      buffer_(kMaxHeadBytes + kMaxBodyBytes) {
  boost::system::error_code ignored;
  const auto peer = connection_.socket().remote_endpoint(ignored);
  peer_ = peer.address().to_string();
  connection_.socket().set_option(tcp::no_delay(true), ignored);
  connection_.socket().set_option(net::socket_base::send_buffer_size(kSendBufferBytes), ignored);
}

Task<void> Session::run() {
  try {
    co_await serve();
    boost::system::error_code ignored;
    connection_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  } catch (const boost::system::system_error&) {
    connection_.close();
  } catch (const std::exception& error) {
    spdlog::error("internal error in a request from {}: {}", peer_, error.what());
    connection_.close();
  }
}

Task<bool> Session::read_head(Request& parser) {
  parser.header_limit(kMaxHeadBytes);
  // No body limit here: Access::judge checks Content-Length before the body is read.
  parser.body_limit(std::numeric_limits<std::uint64_t>::max());
  boost::system::error_code error;
  connection_.expires_after(kRequestTimeout);
  co_await http::async_read_header(connection_, buffer_, parser,
                                   net::redirect_error(net::use_awaitable, error));
  if (!error) co_return true;
  const bool is_request =
      error.category() == http::make_error_code(http::error::bad_target).category();
  if (is_request && error != http::error::end_of_stream && error != http::error::partial_message) {
    const RequestHead unknown;
    co_await refuse(Refusal::malformed, unknown);
  }
  co_return false;
}

Task<void> Session::serve() {
  Request parser;
  if (!co_await read_head(parser)) co_return;
  const RequestHead head = head_of(parser);
  const auto right = parts_.access.judge(head);
  trusted_ = right && *right >= Right::look;
  connection_.expires_after(kWriteTimeout);
  if (!right) {
    co_await refuse(right.error(), head);
  } else if (head.target == "/stream") {
    co_await stream(head, *right);
  } else if (head.target == "/hologram.png") {
    co_await hologram();
  } else if (head.target.starts_with(kImagePath)) {
    co_await image(head);
  } else if (head.target.starts_with(kCommissionPicturePath)) {
    co_await commission_picture(head);
  } else if (head.target == kCommissionPath && head.method == "POST") {
    co_await commission_action(parser, head);
  } else if (head.target == kCommissionPath) {
    std::string report = parts_.commission.report(*right);
    co_await answer("application/json", std::move(report));
  } else if (head.target == "/recordings") {
    co_await recordings();
  } else if (head.target.starts_with(kRecordingPath)) {
    co_await recording(head, *right);
  } else if (head.target == "/ticket") {
    co_await ticket(parser, head);
  } else if (head.target == "/rpc") {
    co_await rpc(parser, head);
  } else {
    const auto file = page_file(head.target);
    std::string text(file->text);
    co_await answer(file->type, std::move(text));
  }
}

Task<void> Session::answer(http::status status, std::string_view type, std::string body) {
  http::response<http::string_body> response;
  prepare(response, type);
  response.result(status);
  response.body() = std::move(body);
  response.prepare_payload();
  co_await http::async_write(connection_, response, net::use_awaitable);
}

Task<void> Session::answer(std::string_view type, std::string body) {
  const auto status = body.empty() ? http::status::no_content : http::status::ok;
  co_await answer(status, type, std::move(body));
}

Task<void> Session::refuse(Refusal why, const RequestHead& head) {
  parts_.refusals.add(why, head, peer_);
  const RefusalRow& row = row_of(why);
  const nlohmann::json body{{"refused", row.name}, {"reason", row.reason}};
  std::string text = json_text(body);
  co_await answer(http::int_to_status(unsigned(row.status)), "application/json", std::move(text));
}

Task<void> Session::stream(const RequestHead& head, Right right) {
  if (parts_.browsers >= kMaxBrowsers) co_return co_await refuse(Refusal::full, head);
  const Counted counted(parts_.browsers);
  http::response<http::empty_body> response;
  prepare(response, "application/octet-stream");
  response.chunked(true);
  http::response_serializer<http::empty_body> serializer(response);
  co_await http::async_write_header(connection_, serializer, net::use_awaitable);
  co_await pump(right);
}

/// Sends new messages of the board to the browser, in a loop. While a slow browser receives, the
/// board replaces messages, so that the next read returns only the newest messages.
Task<void> Session::pump(Right right) {
  net::steady_timer timer(co_await net::this_coro::executor);
  const nlohmann::json hello{{"schema", "ovws.web.hello/1"},
                             {"right", right == Right::control ? "control" : "look"}};
  const std::string first = framed(json_text(hello));
  co_await net::async_write(connection_, http::make_chunk(net::buffer(first)), net::use_awaitable);
  std::uint64_t seen = 0;
  for (;;) {
    const auto packets = parts_.board.newer(seen);
    timer.expires_after(packets.empty() ? kPollInterval : kSendInterval);
    if (!packets.empty()) {
      std::vector<net::const_buffer> buffers;
      for (const PacketPtr& packet : packets) buffers.emplace_back(net::buffer(packet->bytes));
      connection_.expires_after(kStreamTimeout);
      co_await net::async_write(connection_, http::make_chunk(buffers), net::use_awaitable);
    }
    co_await timer.async_wait(net::use_awaitable);
  }
}

Task<void> Session::rpc(Request& parser, const RequestHead& head) {
  connection_.expires_after(kRequestTimeout);
  co_await http::async_read(connection_, buffer_, parser, net::use_awaitable);
  const auto request = parse_command(parser.get().body());
  if (!request) co_return co_await refuse(request.error(), head);
  std::function<std::string()> work = [&common = parts_.common, command = *request,
                                       commanded = parts_.commanded] {
    std::string reply = carry_out(common, command);
    if (changes_bench(command)) commanded();
    return reply;
  };
  co_await answer_from_pool("application/json", std::move(work), kWriteTimeout);
}

Task<void> Session::answer_from_pool(std::string_view type, std::function<std::string()> work,
                                     milliseconds patience) {
  connection_.expires_never();
  auto reply = co_await in_pool<std::string>(callers_, connection_.socket(), work);
  if (!reply) co_return;
  connection_.expires_after(patience);
  co_await answer(type, std::move(*reply));
}

Task<void> Session::commission_action(Request& parser, const RequestHead& head) {
  connection_.expires_after(kRequestTimeout);
  co_await http::async_read(connection_, buffer_, parser, net::use_awaitable);
  auto reply = parts_.commission.act(parser.get().body());
  if (!reply) co_return co_await refuse(reply.error(), head);
  connection_.expires_after(kWriteTimeout);
  co_await answer("application/json", std::move(*reply));
}

Task<void> Session::commission_picture(const RequestHead& head) {
  std::string step = head.target.substr(kCommissionPicturePath.size());
  std::function<std::string()> work = [&desk = parts_.commission, step = std::move(step)] {
    return desk.picture(step);
  };
  co_await answer_from_pool("image/png", std::move(work), kWriteTimeout);
}

/// Answers with a part of the newest image at full resolution, framed like a message of the stream.
Task<void> Session::image(const RequestHead& head) {
  const auto part = parse_image_part(std::string_view(head.target).substr(kImagePath.size()));
  if (!part) co_return co_await refuse(Refusal::malformed, head);
  std::string bytes;
  if (const CameraImagePtr newest = parts_.image()) {
    if (const auto cut = image_part(*newest, *part)) bytes = framed(cut->json, cut->binary);
  }
  co_await answer("application/octet-stream", std::move(bytes));
}

Task<void> Session::hologram() {
  const HologramImagePtr picture = parts_.hologram();
  std::string png = picture ? picture->png : std::string();
  co_await answer("image/png", std::move(png));
}

}  // namespace ovws::web
