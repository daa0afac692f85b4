#include "drivers/zmq/client.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "drivers/zmq/endpoint.hpp"

namespace ovws {
namespace {

bool readable(zmq::socket_t& socket, std::chrono::milliseconds timeout) {
  zmq_pollitem_t item{socket.handle(), 0, ZMQ_POLLIN, 0};
  return zmq_poll(&item, 1, long(timeout.count())) > 0;
}

constexpr std::chrono::seconds kAfterSignal{10};  // a program that catches signals is about to end

std::vector<zmq::message_t> receive_parts(zmq::socket_t& socket) {
  std::vector<zmq::message_t> parts;
  (void)zmq::recv_multipart(socket, std::back_inserter(parts), zmq::recv_flags::dontwait);
  return parts;
}

Result<void> set_keys(zmq::socket_t& socket, const std::optional<ClientKeys>& keys) {
  if (!keys) return {};
  if (!is_curve_key(keys->server_key)) {
    return fail(Errc::invalid, "server_key",
                "must be the daemon's public key: the 40 characters that ovws keygen printed when "
                "the daemon's key was made");
  }
  if (public_key_of(keys->own.secret_key) != keys->own.public_key) {
    return fail(Errc::invalid, "key", "is not a pair of keys: make one with ovws keygen");
  }
  socket.set(zmq::sockopt::curve_publickey, keys->own.public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys->own.secret_key);
  socket.set(zmq::sockopt::curve_serverkey, keys->server_key);
  return {};
}

constexpr int kHandshakeEvents = ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_AUTH |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;

/// Why a CURVE handshake failed, as far as the client can determine it.
std::string rejection_reason(int event, bool has_keys) {
  if (event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
    return "the daemon does not know this client's key: add its public key to the daemon's file of "
           "security.clients";
  }
  if (!has_keys) {
    return "the daemon requires a key: give --key FILE (ovws keygen makes one) and --server-key "
           "KEY, or OVWS_KEY and OVWS_SERVER_KEY";
  }
  if (event == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL) {
    return "the daemon there uses no keys, or it is not a daemon: leave out --key, or check the "
           "endpoint";
  }
  return "the connection ended in the handshake: check that the server key belongs to this daemon";
}

/// Event number in a message of a ZeroMQ socket monitor; 0 if the message is malformed.
int event_of(const std::vector<zmq::message_t>& parts) {
  std::uint16_t event = 0;
  if (!parts.empty() && parts[0].size() >= sizeof event) {
    std::memcpy(&event, parts[0].data(), sizeof event);
  }
  return event;
}

}  // namespace

struct ControlClient::Impl {
  std::string endpoint;
  std::optional<ClientKeys> keys;
  zmq::context_t context{1};
  zmq::socket_t socket;
  zmq::socket_t monitor;
  int opened = 0;

  /// Opens a new socket. Its routing id is new, so replies to older requests never reach this
  /// socket.
  Result<void> open() {
    socket = zmq::socket_t(context, zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    if (auto keys_set = set_keys(socket, keys); !keys_set) return keys_set;
    const std::string events = "inproc://handshakes-" + std::to_string(opened++);
    zmq_socket_monitor(socket.handle(), events.c_str(), kHandshakeEvents);
    monitor = zmq::socket_t(context, zmq::socket_type::pair);
    monitor.set(zmq::sockopt::linger, 0);
    monitor.connect(events);
    return connect_endpoint(socket.handle(), endpoint);
  }

  /// Waits for a reply, a rejected handshake or the time-out. Returns the event of the last failed
  /// handshake; 0 if a reply came or no handshake failed. If a connection ended without a reason,
  /// waiting continues, because libzmq connects again. After a signal it continues for
  /// kAfterSignal: what the request has begun must be known in order to end it.
  int wait(std::chrono::milliseconds timeout) {
    using Clock = std::chrono::steady_clock;
    auto end = Clock::now() + timeout;
    int event = 0;
    while (event == 0 || event == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count();
      std::array<zmq_pollitem_t, 2> items{
          {{socket.handle(), 0, ZMQ_POLLIN, 0}, {monitor.handle(), 0, ZMQ_POLLIN, 0}}};
      const int woken = zmq_poll(items.data(), int(items.size()), long(left > 0 ? left : 0));
      if (woken < 0 && zmq_errno() == EINTR) {
        end = std::min(end, Clock::now() + kAfterSignal);
        continue;
      }
      if ((items[0].revents & ZMQ_POLLIN) != 0) return 0;
      if (woken > 0) event = event_of(receive_parts(monitor));
      if (left <= 0 || woken <= 0) break;
    }
    return event;
  }
};

Result<ControlClient> ControlClient::connect(const std::string& endpoint,
                                             const std::optional<ClientKeys>& keys) {
  auto impl = make_hidden<Impl>();
  impl->endpoint = endpoint;
  impl->keys = keys;
  if (auto opened = impl->open(); !opened) return fail(opened.error());
  return ControlClient(std::move(impl));
}

Result<std::string> ControlClient::request(std::string_view bytes,
                                           std::chrono::milliseconds timeout,
                                           std::vector<std::byte>* binary) {
  (void)impl_->socket.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
  const int event = impl_->wait(timeout);
  const auto parts = receive_parts(impl_->socket);
  if (!parts.empty()) {
    const bool delimited = parts.size() > 1 && parts.front().size() == 0;  // by other programs
    const std::size_t first = delimited ? 1 : 0;
    if (binary != nullptr && parts.size() > first + 1) {
      const auto* const data = parts[first + 1].data<std::byte>();
      binary->assign(data, data + parts[first + 1].size());
    }
    return parts[first].to_string();
  }
  if (auto opened = impl_->open(); !opened) return fail(opened.error());
  if (event != 0) {
    return fail(Errc::refused, "",
                impl_->endpoint + ": " + rejection_reason(event, impl_->keys.has_value()));
  }
  return fail(Errc::unavailable, "",
              "no answer from " + impl_->endpoint + " within " + std::to_string(timeout.count()) +
                  " ms; does the daemon run, and is this its control endpoint?");
}

struct Subscriber::Impl {
  zmq::context_t context{1};
  zmq::socket_t socket{context, zmq::socket_type::sub};
  std::vector<std::string> topics;  ///< empty: all

  /// ZeroMQ matches topics by prefix: "wavefront" brings those of all light sources.
  bool takes(std::string_view topic) const {
    return topics.empty() || std::find(topics.begin(), topics.end(), topic) != topics.end();
  }
};

Result<Subscriber> Subscriber::connect(const std::string& endpoint,
                                       const std::vector<std::string>& topics, int receive_queue,
                                       const std::optional<ClientKeys>& keys) {
  auto impl = make_hidden<Impl>();
  if (auto keys_set = set_keys(impl->socket, keys); !keys_set) return fail(keys_set.error());
  impl->socket.set(zmq::sockopt::linger, 0);
  impl->socket.set(zmq::sockopt::rcvhwm, receive_queue);
  for (const auto& topic : topics) impl->socket.set(zmq::sockopt::subscribe, topic);
  if (topics.empty()) impl->socket.set(zmq::sockopt::subscribe, "");
  impl->topics = topics;
  if (auto connected = connect_endpoint(impl->socket.handle(), endpoint); !connected) {
    return fail(connected.error());
  }
  return Subscriber(std::move(impl));
}

std::optional<StreamMessage> Subscriber::receive(std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + timeout;
  std::vector<zmq::message_t> parts;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    if (!readable(impl_->socket, std::max(left, std::chrono::milliseconds(0)))) return std::nullopt;
    parts = receive_parts(impl_->socket);
    if (parts.size() < 2) return std::nullopt;  // not a message of ovwsd
  } while (!impl_->takes(parts[0].to_string_view()));
  StreamMessage message{parts[0].to_string(), parts[1].to_string(), {}};
  if (parts.size() > 2) {
    message.binary.resize(parts[2].size());
    std::memcpy(message.binary.data(), parts[2].data(), parts[2].size());
  }
  return message;
}

}  // namespace ovws
