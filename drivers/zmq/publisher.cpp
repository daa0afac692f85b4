#include "drivers/zmq/publisher.hpp"

#include <utility>
#include <zmq.hpp>

#include "drivers/zmq/endpoint.hpp"
#include "drivers/zmq/gate_parts.hpp"

namespace ovws {

struct Publisher::Impl {
  Impl(std::string at, Gate* by)
      : endpoint(std::move(at)),
        gate(by),
        context(context_of(gate)),
        socket(*context, zmq::socket_type::pub) {
    if (gate != nullptr) gate->parts().guard(socket);
  }

  std::string endpoint;
  Gate* gate;
  std::shared_ptr<zmq::context_t> context;
  zmq::socket_t socket;
  unsigned generation = 0;
  bool bound = true;

  /// Unbinding ends all connections. The old listener ends in libzmq's own thread: until it has,
  /// the address is in use.
  bool is_bound() {
    if (gate == nullptr) return true;
    const unsigned wanted = gate->parts().generation.load();
    if (std::exchange(generation, wanted) != wanted && std::exchange(bound, false)) {
      zmq_unbind(socket.handle(), endpoint.c_str());
    }
    bound = bound || bind_endpoint(socket.handle(), endpoint).has_value();
    return bound;
  }

  bool part(const void* data, std::size_t size, bool more) {
    const auto flags =
        more ? zmq::send_flags::sndmore | zmq::send_flags::dontwait : zmq::send_flags::dontwait;
    return socket.send(zmq::const_buffer(data, size), flags).has_value();
  }
};

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Publisher::Publisher(Publisher&&) noexcept = default;
Publisher& Publisher::operator=(Publisher&&) noexcept = default;
Publisher::~Publisher() = default;

Result<Publisher> Publisher::bind(const std::string& endpoint, int send_queue, Gate* gate) {
  auto impl = std::make_unique<Impl>(endpoint, gate);
  impl->socket.set(zmq::sockopt::sndhwm, send_queue);
  impl->socket.set(zmq::sockopt::linger, 0);
  if (auto bound = bind_endpoint(impl->socket.handle(), endpoint); !bound) {
    return fail(bound.error());
  }
  return Publisher(std::move(impl));
}

bool Publisher::send(std::string_view topic, std::string_view json,
                     std::span<const std::byte> binary) {
  if (!impl_->is_bound()) return false;
  // A PUB socket drops for each subscriber alone, and whole messages; once the first part is
  // taken, the rest is.
  return impl_->part(topic.data(), topic.size(), true) &&
         impl_->part(json.data(), json.size(), !binary.empty()) &&
         (binary.empty() || impl_->part(binary.data(), binary.size(), false));
}

}  // namespace ovws
