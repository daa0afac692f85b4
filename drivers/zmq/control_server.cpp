#include "drivers/zmq/control_server.hpp"

#include <vector>
#include <zmq.hpp>

#include "drivers/zmq/endpoint.hpp"
#include "drivers/zmq/gate_parts.hpp"
#include "drivers/zmq/reply_box.hpp"

namespace ovws {
namespace {

constexpr long kWaitMs = 50;
constexpr int kLingerMs = 100;  // what was answered last may leave before the socket closes
constexpr int kTurn = 64;       // requests taken before replies are looked at
constexpr std::size_t kMaxPending = 128;  // beyond, requests wait in the sockets
// ROUTER drops what one client's queue does not hold: all that can be pending must fit.
constexpr int kReplyQueue = 2 * int(kMaxPending);
constexpr int kReceiveQueue = 32;                 // requests held for one client
constexpr std::int64_t kMaxFrameBytes = 2 << 20;  // beyond, libzmq ends the connection
constexpr std::size_t kMaxParts = 16;             // of one request, its envelope included

/// One multipart request. Parts beyond kMaxParts are counted and not kept.
struct Incoming {
  std::vector<zmq::message_t> parts;
  std::size_t count = 0;
};

/// The envelope ends with the first empty frame before the last; a DEALER may leave that out, and
/// then it is the routing id alone.
std::size_t envelope_size(const Incoming& in) {
  for (std::size_t k = 1; k + 1 < in.parts.size(); ++k) {
    if (in.parts[k].size() == 0) return k + 1;
  }
  return 1;
}

/// The key that the gate let in.
std::string asker_of(const zmq::message_t& part) {
  const char* key = zmq_msg_gets(part.handle(), "User-Id");
  return key == nullptr ? "" : key;
}

}  // namespace

struct ControlServer::Impl {
  explicit Impl(Gate* by)
      : gate(by), context(context_of(gate)), socket(*context, zmq::socket_type::router) {
    if (gate != nullptr) gate->parts().guard(socket);
  }

  Gate* gate;
  std::shared_ptr<zmq::context_t> context;
  zmq::socket_t socket;
  std::shared_ptr<ReplyBox> box = std::make_shared<ReplyBox>();
  std::size_t max_request_bytes = 0;
  std::string oversize_reply;
  ControlHandler handler;
  std::vector<zmq_pollitem_t> items;

  bool wait();
  bool send_replies();
  bool take_request();
  void serve(const Incoming& in);
};

/// Until something is to be done, at most kWaitMs. Too many requests pending: new ones are left
/// where they are.
bool ControlServer::Impl::wait() {
  const bool room = box->pending() < kMaxPending;
  items.assign(1, {nullptr, box->wake_fd(), ZMQ_POLLIN, 0});
  if (gate != nullptr) gate->parts().add_to(items);
  if (room) items.push_back({socket.handle(), 0, ZMQ_POLLIN, 0});
  return zmq_poll(items.data(), int(items.size()), kWaitMs) > 0;  // interrupted: a short wait
}

bool ControlServer::Impl::send_replies() {
  const auto replies = box->collect();
  for (const auto& [envelope, bytes] : replies) {
    // To a client that is gone, or that does not read its replies, ROUTER drops: its own loss.
    for (const auto& frame : envelope) {
      (void)socket.send(zmq::buffer(frame), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
    }
    (void)socket.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
  }
  return !replies.empty();
}

bool ControlServer::Impl::take_request() {
  Incoming in;
  bool more = true;
  while (more) {
    zmq::message_t part;
    if (!socket.recv(part, zmq::recv_flags::dontwait)) return false;  // parts come all or none
    more = part.more();
    ++in.count;
    if (in.parts.size() < kMaxParts) in.parts.push_back(std::move(part));
  }
  serve(in);
  return true;
}

void ControlServer::Impl::serve(const Incoming& in) {
  const std::size_t size = envelope_size(in);
  Envelope envelope;
  for (std::size_t k = 0; k < size; ++k) envelope.push_back(in.parts[k].to_string());
  const auto reply = box->reply_to(std::move(envelope));
  if (in.count == 1) return;  // a routing id alone asks for nothing and has nowhere to go
  const bool one_frame = in.count == size + 1;
  if (!one_frame || in.parts[size].size() > max_request_bytes) return reply(oversize_reply);
  handler(in.parts[size].to_string_view(), gate != nullptr ? asker_of(in.parts[size]) : "", reply);
}

ControlServer::ControlServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ControlServer::~ControlServer() = default;

Result<std::unique_ptr<ControlServer>> ControlServer::bind(const std::string& endpoint,
                                                           std::size_t max_request_bytes,
                                                           std::string oversize_reply,
                                                           ControlHandler handler, Gate* gate) {
  auto impl = std::make_unique<Impl>(gate);
  impl->max_request_bytes = max_request_bytes;
  impl->oversize_reply = std::move(oversize_reply);
  impl->handler = std::move(handler);
  impl->socket.set(zmq::sockopt::linger, kLingerMs);
  impl->socket.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  impl->socket.set(zmq::sockopt::rcvhwm, kReceiveQueue);
  impl->socket.set(zmq::sockopt::sndhwm, kReplyQueue);
  if (auto bound = bind_endpoint(impl->socket.handle(), endpoint); !bound) {
    return fail(bound.error());
  }
  return std::unique_ptr<ControlServer>(new ControlServer(std::move(impl)));
}

void ControlServer::on_close() {
  impl_->send_replies();
}

bool ControlServer::do_work() {
  impl_->wait();
  if (impl_->gate != nullptr) impl_->gate->parts().serve();
  bool worked = impl_->send_replies();
  for (int k = 0; k < kTurn && impl_->box->pending() < kMaxPending; ++k) {
    if (!impl_->take_request()) break;
    worked = true;
  }
  return impl_->send_replies() || worked;
}

}  // namespace ovws
