#include "drivers/twin/control.hpp"

#include <chrono>
#include <utility>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

namespace ovws::twin {

struct Control::Impl {
  zmq::context_t context{1};
  zmq::socket_t socket{context, zmq::socket_type::router};
  std::string endpoint;

  void answer(std::vector<zmq::message_t>& parts, const RpcDispatch& dispatch);
};

Control::Control(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Control::~Control() = default;

Result<std::unique_ptr<Control>> Control::bind(const std::string& endpoint) {
  auto impl = std::make_unique<Impl>();
  try {
    impl->socket.set(zmq::sockopt::linger, 0);
    impl->socket.set(zmq::sockopt::maxmsgsize, std::int64_t(16 * kMaxRequestBytes));
    impl->socket.bind(endpoint);
    impl->endpoint = impl->socket.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& e) {
    const bool taken = e.num() == EADDRINUSE;
    return fail(taken ? Errc::unavailable : Errc::invalid, "control.endpoint",
                taken ? endpoint + " is taken: another twin runs on this machine?"
                      : "cannot listen at " + endpoint + ": " + e.what());
  }
  return std::unique_ptr<Control>(new Control(std::move(impl)));
}

const std::string& Control::endpoint() const {
  return impl_->endpoint;
}

void Control::Impl::answer(std::vector<zmq::message_t>& parts, const RpcDispatch& dispatch) {
  const zmq::message_t& request = parts.back();
  const auto send = [&](const std::string& reply) {
    if (reply.empty()) return;
    parts.back().rebuild(reply.data(), reply.size());
    // The routing id, and the empty delimiter if there was one, are sent back unchanged.
    zmq::send_multipart(socket, parts, zmq::send_flags::dontwait);
  };
  if (request.size() > kMaxRequestBytes) return send(oversize_reply());
  // Copied, because the reply replaces the request's message.
  const std::string bytes(request.data<char>(), request.size());
  handle_rpc_frame(bytes, dispatch, send);
}

void Control::work(const std::stop_token& stop, const RpcDispatch& dispatch) {
  while (!stop.stop_requested()) {
    try {
      zmq::pollitem_t readable{impl_->socket.handle(), 0, ZMQ_POLLIN, 0};
      if (zmq::poll(&readable, 1, std::chrono::milliseconds(50)) == 0) continue;
      std::vector<zmq::message_t> parts;
      if (!zmq::recv_multipart(impl_->socket, std::back_inserter(parts))) continue;
      if (parts.size() >= 2) impl_->answer(parts, dispatch);
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR && e.num() != EHOSTUNREACH && e.num() != EAGAIN) throw;
    }
  }
}

}  // namespace ovws::twin
