#include "drivers/zmq/client.hpp"

#include <cstring>
#include <zmq.hpp>

#include "drivers/zmq/endpoint.hpp"

namespace ovws {
namespace {

bool readable(zmq::socket_t& socket, std::chrono::milliseconds timeout) {
  zmq_pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
  return zmq_poll(&item, 1, long(timeout.count())) > 0;
}

std::vector<zmq::message_t> receive_parts(zmq::socket_t& socket) {
  std::vector<zmq::message_t> parts;
  do {
    zmq::message_t part;
    if (!socket.recv(part, zmq::recv_flags::dontwait)) break;
    parts.push_back(std::move(part));
  } while (parts.back().more());
  return parts;
}

}  // namespace

struct ControlClient::Impl {
  std::string endpoint;
  zmq::context_t context{1};
  zmq::socket_t socket;

  /// A new socket has a new routing id, so that replies to older requests never reach it.
  Result<void> open() {
    socket = zmq::socket_t(context, zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    return connect_endpoint(socket.handle(), endpoint);
  }
};

ControlClient::ControlClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ControlClient::ControlClient(ControlClient&&) noexcept = default;
ControlClient& ControlClient::operator=(ControlClient&&) noexcept = default;
ControlClient::~ControlClient() = default;

Result<ControlClient> ControlClient::connect(const std::string& endpoint) {
  auto impl = std::make_unique<Impl>();
  impl->endpoint = endpoint;
  if (auto opened = impl->open(); !opened) return fail(opened.error());
  return ControlClient(std::move(impl));
}

Result<std::string> ControlClient::request(std::string_view bytes,
                                           std::chrono::milliseconds timeout) {
  (void)impl_->socket.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
  if (readable(impl_->socket, timeout)) {
    const auto parts = receive_parts(impl_->socket);
    if (!parts.empty()) return parts.back().to_string();
  }
  if (auto opened = impl_->open(); !opened) return fail(opened.error());
  return fail(Errc::unavailable, "",
              "no answer from " + impl_->endpoint + " within " + std::to_string(timeout.count()) +
                  " ms; does the daemon run, and is this its control endpoint?");
}

struct Subscriber::Impl {
  zmq::context_t context{1};
  zmq::socket_t socket{context, zmq::socket_type::sub};
};

Subscriber::Subscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Subscriber::Subscriber(Subscriber&&) noexcept = default;
Subscriber& Subscriber::operator=(Subscriber&&) noexcept = default;
Subscriber::~Subscriber() = default;

Result<Subscriber> Subscriber::connect(const std::string& endpoint,
                                       const std::vector<std::string>& topics, int receive_queue) {
  auto impl = std::make_unique<Impl>();
  impl->socket.set(zmq::sockopt::linger, 0);
  impl->socket.set(zmq::sockopt::rcvhwm, receive_queue);
  for (const auto& topic : topics) impl->socket.set(zmq::sockopt::subscribe, topic);
  if (topics.empty()) impl->socket.set(zmq::sockopt::subscribe, "");
  if (auto connected = connect_endpoint(impl->socket.handle(), endpoint); !connected) {
    return fail(connected.error());
  }
  return Subscriber(std::move(impl));
}

std::optional<StreamMessage> Subscriber::receive(std::chrono::milliseconds timeout) {
  if (!readable(impl_->socket, timeout)) return std::nullopt;
  const auto parts = receive_parts(impl_->socket);
  if (parts.size() < 2) return std::nullopt;  // not from one of our daemons
  StreamMessage message{parts[0].to_string(), parts[1].to_string(), {}};
  if (parts.size() > 2) {
    message.binary.resize(parts[2].size());
    std::memcpy(message.binary.data(), parts[2].data(), parts[2].size());
  }
  return message;
}

}  // namespace ovws
