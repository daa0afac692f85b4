#include "drivers/zmq/publisher.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "drivers/zmq/endpoint.hpp"
#include "drivers/zmq/gate_parts.hpp"

namespace ovws {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kMaxIncomingBytes =
    4096;  // incoming messages are only handshakes and subscriptions
constexpr auto kBetweenTries = std::chrono::milliseconds(100);
constexpr auto kPatience = std::chrono::seconds(1);  // delay until a failure is reported

}  // namespace

struct Publisher::Impl {
  Impl(std::string at, Gate* by)
      : endpoint(std::move(at)),
        gate(by),
        context(context_of(gate)),
        socket(*context, zmq::socket_type::pub) {
    if (gate != nullptr) gate->parts().guard(socket, Gate::Parts::UnknownKey::retry);
  }

  std::string endpoint;
  Gate* gate;
  std::shared_ptr<zmq::context_t> context;
  zmq::socket_t socket;
  std::string bound_at;  ///< `endpoint` in libzmq's form: tcp://0.0.0.0:PORT for tcp://*:PORT
  unsigned generation = 0;
  bool bound = false;
  Clock::time_point next_try{}, unbound_since{};
  bool failure_reported = false;

  Result<void> bind() {
    if (auto done = bind_endpoint(socket.handle(), endpoint); !done) return done;
    bound_at = socket.get(zmq::sockopt::last_endpoint);
    bound = true;
    return {};
  }

  /// Rebinds after Gate::end_streams, which increases the gate's generation: unbinding disconnects
  /// all subscribers, who must then authenticate again. Returns whether the socket is bound. libzmq
  /// closes the old listener later, in its own thread; until then binding fails.
  bool is_bound() {
    if (gate == nullptr) return true;
    const unsigned wanted = gate->parts().generation.load();
    if (bound && generation != wanted) {
      bound = zmq_unbind(socket.handle(), bound_at.c_str()) != 0;
      generation = bound ? generation : wanted;
      if (!bound) unbound_since = Clock::now();
    }
    if (bound || Clock::now() < next_try) return bound && generation == wanted;
    next_try = Clock::now() + kBetweenTries;
    const auto done = bind();
    report(done);
    return done.has_value();
  }

  /// Reports a failure to rebind once, when it has lasted for kPatience, and reports the recovery.
  void report(const Result<void>& done) {
    if (!done && (failure_reported || Clock::now() - unbound_since < kPatience)) return;
    if (done && !failure_reported) return;
    failure_reported = !done;
    gate->parts().calls.rebound(endpoint, done);
  }
};

Result<Publisher> Publisher::bind(const std::string& endpoint, int send_queue, Gate* gate) {
  auto impl = make_hidden<Impl>(endpoint, gate);
  impl->socket.set(zmq::sockopt::sndhwm, send_queue);
  impl->socket.set(zmq::sockopt::linger, 0);
  // Limit of incoming frames: libzmq allocates the size that a frame announces even before the
  // client is authenticated.
  impl->socket.set(zmq::sockopt::maxmsgsize, kMaxIncomingBytes);
  if (auto bound = impl->bind(); !bound) return fail(bound.error());
  return Publisher(std::move(impl));
}

bool Publisher::send(std::string_view topic, std::string_view json,
                     std::span<const std::byte> binary) {
  if (!impl_->is_bound()) return false;
  // A PUB socket drops whole messages only, for each subscriber separately. If it accepts the first
  // part of a message, it accepts all parts.
  const std::array parts{zmq::buffer(topic), zmq::buffer(json),
                         zmq::buffer(binary.data(), binary.size())};
  return zmq::send_multipart(impl_->socket, std::span(parts).first(binary.empty() ? 2 : 3),
                             zmq::send_flags::dontwait)
      .has_value();
}

}  // namespace ovws
