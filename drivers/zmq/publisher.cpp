#include "drivers/zmq/publisher.hpp"

#include <zmq.hpp>

#include "drivers/zmq/endpoint.hpp"

namespace ovws {

struct Publisher::Impl {
  zmq::context_t context{1};
  zmq::socket_t socket{context, zmq::socket_type::pub};

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

Result<Publisher> Publisher::bind(const std::string& endpoint, int send_queue) {
  auto impl = std::make_unique<Impl>();
  impl->socket.set(zmq::sockopt::sndhwm, send_queue);
  impl->socket.set(zmq::sockopt::linger, 0);
  if (auto bound = bind_endpoint(impl->socket.handle(), endpoint); !bound) {
    return fail(bound.error());
  }
  return Publisher(std::move(impl));
}

bool Publisher::send(std::string_view topic, std::string_view json,
                     std::span<const std::byte> binary) {
  // A PUB socket drops for each subscriber alone, and whole messages; once the first part is
  // taken, the rest is.
  return impl_->part(topic.data(), topic.size(), true) &&
         impl_->part(json.data(), json.size(), !binary.empty()) &&
         (binary.empty() || impl_->part(binary.data(), binary.size(), false));
}

}  // namespace ovws
