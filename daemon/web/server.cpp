#include "daemon/web/server.hpp"

#include <algorithm>
#include <list>

#include "daemon/web/session.hpp"

namespace ovws::web {
namespace {

constexpr std::chrono::milliseconds kNoDescriptors{100};
constexpr std::size_t kCalls = 4;  ///< concurrent calls to the daemon

}  // namespace

struct Server::Impl {
  ServerParts parts;
  std::list<Session*> sessions;  ///< oldest first
  net::io_context io{1};
  tcp::acceptor acceptor{io};
  net::thread_pool callers{kCalls};  ///< drops waiting calls; destroyed before `io`

  explicit Impl(ServerParts given) : parts(std::move(given)) {}

  Task<void> serve(tcp::socket socket) {
    Session session(std::move(socket), parts, callers);
    sessions.push_back(&session);
    co_await session.run();
    sessions.remove(&session);
  }

  /// Whether one more connection is allowed. If all slots are in use, closes the oldest connection
  /// without a token.
  bool make_room() {
    if (sessions.size() < kMaxConnections) return true;
    parts.refusals.add(Refusal::full, {}, "all connection slots are in use");
    const auto stranger = std::ranges::find_if_not(sessions, &Session::trusted);
    if (stranger == sessions.end()) return false;
    (*stranger)->end();
    sessions.erase(stranger);
    return true;
  }

  Task<void> accept() {
    for (;;) {
      boost::system::error_code error;
      tcp::socket socket =
          co_await acceptor.async_accept(net::redirect_error(net::use_awaitable, error));
      if (error) {
        net::steady_timer pause(io, kNoDescriptors);
        co_await pause.async_wait(net::use_awaitable);
        continue;
      }
      if (make_room()) net::co_spawn(io, serve(std::move(socket)), net::detached);
    }
  }
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::listen(const std::string& address, unsigned short port,
                                               ServerParts parts) {
  boost::system::error_code error;
  const auto host = net::ip::make_address(address, error);
  if (error) return fail(Errc::invalid, "--listen", "the address must be numeric: " + address);
  auto impl = std::make_unique<Impl>(std::move(parts));
  const tcp::endpoint endpoint(host, port);
  impl->acceptor.open(endpoint.protocol(), error);
  if (!error) impl->acceptor.set_option(net::socket_base::reuse_address(true), error);
  if (!error) impl->acceptor.bind(endpoint, error);
  if (!error) impl->acceptor.listen(net::socket_base::max_listen_connections, error);
  if (error) {
    return fail(Errc::unavailable, "--listen",
                address + ":" + std::to_string(port) + ": " + error.message());
  }
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

void Server::run() {
  net::signal_set signals(impl_->io, SIGINT, SIGTERM);
  signals.async_wait([this](const boost::system::error_code&, int) { impl_->io.stop(); });
  net::co_spawn(impl_->io, impl_->accept(), net::detached);
  impl_->io.run();
}

}  // namespace ovws::web
