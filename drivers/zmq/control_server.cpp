#include "drivers/zmq/control_server.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>
#include <zmq.hpp>

#include "drivers/zmq/endpoint.hpp"
#include "drivers/zmq/gate_parts.hpp"
#include "drivers/zmq/reply_box.hpp"
#include "drivers/zmq/request_turns.hpp"

namespace ovws {
namespace {

constexpr long kWaitMs = 50;
constexpr int kLingerMs = 100;  // time for the last replies to be sent before the socket closes
constexpr int kMaxRequestsPerTurn = 64;  // requests received before serving begins
constexpr auto kServeFor = std::chrono::milliseconds(10);  // time limit of one `serve`
// Send queue without a limit, because ROUTER drops replies beyond a client's high-water mark, and
// libzmq counts replies for a while after it has written them. ReplyBox limits the replies instead.
constexpr int kReplyQueue = 0;                   // 0: unlimited
constexpr std::size_t kReceiveBytes = 16 << 20;  // of the requests that libzmq holds per client
constexpr int kUnreadMs = 60'000;  // a client that takes nothing for so long is disconnected
constexpr std::size_t kMaxFrameBytes = 2 << 20;  // larger frames make libzmq close the connection
constexpr std::size_t kMaxParts = 16;            // frames of one request, with its envelope
constexpr std::size_t kMaxRoutingId = 255;       // bytes, defined by ZeroMQ

/// One multipart request. Parts beyond kMaxParts are counted but not kept.
struct Incoming {
  std::vector<zmq::message_t> parts;
  std::size_t count = 0;
};

/// Number of frames before the request: routing ids, then an empty delimiter. A DEALER may omit the
/// delimiter. If there is none before a frame that is too long for a routing id, only the first
/// frame counts. The last frame belongs to the request.
std::size_t envelope_size(const Incoming& in) {
  for (std::size_t k = 1; k + 1 < in.parts.size(); ++k) {
    if (in.parts[k].size() == 0) return k + 1;
    if (in.parts[k].size() > kMaxRoutingId) break;
  }
  return 1;
}

/// The client's public key as authenticated by the gate.
std::string client_key_of(const zmq::message_t& part) {
  const char* key = zmq_msg_gets(part.handle(), "User-Id");
  return key == nullptr ? "" : key;
}

}  // namespace

struct ControlServer::Impl {
  explicit Impl(Gate* by)
      : gate(by), context(context_of(gate)), socket(*context, zmq::socket_type::router) {
    if (gate != nullptr) gate->parts().guard(socket, Gate::Parts::UnknownKey::reject);
  }

  Gate* gate;
  std::shared_ptr<zmq::context_t> context;
  zmq::socket_t socket;
  std::shared_ptr<ReplyBox> box = std::make_shared<ReplyBox>();
  RequestTurns turns{box};
  ControlLimits limits;
  ControlHandler handler;
  bool more_to_serve = false;  ///< the last `serve` ended by its time limit
  std::vector<zmq_pollitem_t> items;

  bool wait();
  bool send_replies();
  void send(ReplyBox::Reply reply);
  bool receive();
  void take(const Incoming& in);
  bool serve();
};

/// Waits for requests, replies or ZAP messages, at most kWaitMs. No wait if more_to_serve.
bool ControlServer::Impl::wait() {
  items.assign(1, {nullptr, box->wake_fd(), ZMQ_POLLIN, 0});
  if (gate != nullptr) gate->parts().add_to(items);
  items.push_back({socket.handle(), 0, ZMQ_POLLIN, 0});
  const long wait_ms = more_to_serve ? 0 : kWaitMs;
  return zmq_poll(items.data(), int(items.size()), wait_ms) > 0;  // a signal ends the wait early
}

bool ControlServer::Impl::send_replies() {
  auto replies = box->collect();
  for (auto& reply : replies) send(std::move(reply));
  return !replies.empty();
}

/// Sends a reply without copying it. libzmq holds the bytes until they are written to the
/// connection; until then the reply counts as outstanding.
void ControlServer::Impl::send(ReplyBox::Reply reply) {
  struct Sent {
    std::shared_ptr<ReplyBox> box;
    ReplyBox::Reply reply;
  };
  // ROUTER drops messages for a client that has disconnected.
  const auto more = zmq::send_flags::sndmore | zmq::send_flags::dontwait;
  for (const auto& frame : reply.envelope) (void)socket.send(zmq::buffer(frame), more);
  auto kept = std::unique_ptr<Sent>(new Sent{box, std::move(reply)});
  const ReplyBox::Reply& sending = kept->reply;
  const bool alone = sending.binary == nullptr;
  if (!alone) (void)socket.send(zmq::buffer(sending.bytes), more);
  const std::string& last = alone ? sending.bytes : *sending.binary;
  zmq::message_t message(
      const_cast<char*>(last.data()), last.size(),  // NOLINT: libzmq only reads it
      [](void*, void* hint) {
        const std::unique_ptr<Sent> done(static_cast<Sent*>(hint));
        done->box->sent(*done->reply.client, done->reply.size());
      },
      kept.get());
  (void)kept.release();
  (void)socket.send(message, zmq::send_flags::dontwait);
}

bool ControlServer::Impl::receive() {
  Incoming in;
  bool more = true;
  while (more) {
    zmq::message_t part;
    if (!socket.recv(part, zmq::recv_flags::dontwait)) return false;  // parts come all or none
    more = part.more();
    ++in.count;
    if (in.parts.size() < kMaxParts) in.parts.push_back(std::move(part));
  }
  take(in);
  return true;
}

/// Queues a request for its client. The bytes are copied, because a received message may keep a
/// larger buffer of libzmq allocated.
void ControlServer::Impl::take(const Incoming& in) {
  if (in.count == 1) return;  // a routing id without a request
  const std::size_t size = envelope_size(in);
  Request request;
  for (std::size_t k = 0; k < size; ++k) request.envelope.push_back(in.parts[k].to_string());
  const std::size_t frames = in.count - size;
  request.well_sized = frames <= 2 && in.parts[size].size() <= limits.max_request_bytes &&
                       (frames == 1 || in.parts[size + 1].size() <= limits.max_binary_bytes);
  if (frames == 2 && limits.max_binary_bytes == 0) request.well_sized = false;
  if (request.well_sized) request.body.bytes = in.parts[size].to_string();
  if (request.well_sized && frames == 2) request.body.binary = in.parts[size + 1].to_string();
  if (gate != nullptr) request.body.client_key = client_key_of(in.parts[size]);
  Envelope envelope = request.envelope;
  if (turns.push(std::move(request))) return;
  auto client = turns.load_of(envelope.front());
  if (!box->can_refuse(*client)) return;  // the client reads no replies: dropped
  box->reply_to(std::move(envelope), std::move(client), 0)(limits.overload_reply, nullptr);
}

/// Serves requests round-robin over the clients, until none can be served or kServeFor has passed.
bool ControlServer::Impl::serve() {
  const auto until = std::chrono::steady_clock::now() + kServeFor;
  bool served = false;
  more_to_serve = true;
  while (auto turn = turns.next()) {
    Request& request = turn->request;
    const auto reply = box->reply_to(std::move(request.envelope), turn->client,
                                     request.body.bytes.size() + request.body.binary.size());
    if (request.well_sized) {
      handler(std::move(request.body), reply);
    } else {
      reply(limits.oversize_reply, nullptr);
    }
    served = true;
    if (std::chrono::steady_clock::now() >= until) return served;
  }
  more_to_serve = false;
  return served;
}

Result<std::unique_ptr<ControlServer>> ControlServer::bind(const std::string& endpoint,
                                                           ControlLimits limits,
                                                           ControlHandler handler, Gate* gate) {
  auto impl = make_hidden<Impl>(gate);
  impl->limits = std::move(limits);
  impl->handler = std::move(handler);
  impl->socket.set(zmq::sockopt::linger, kLingerMs);
  impl->socket.set(zmq::sockopt::tcp_maxrt, kUnreadMs);
  const std::size_t frame_bytes = std::max(kMaxFrameBytes, impl->limits.max_binary_bytes);
  impl->socket.set(zmq::sockopt::maxmsgsize, std::int64_t(frame_bytes));
  impl->socket.set(zmq::sockopt::rcvhwm,
                   int(std::max<std::size_t>(2, kReceiveBytes / frame_bytes)));
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
  for (int k = 0; k < kMaxRequestsPerTurn && impl_->receive(); ++k) worked = true;
  worked = impl_->serve() || worked;
  return impl_->send_replies() || worked;
}

}  // namespace ovws
