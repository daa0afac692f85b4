#include "drivers/zmq/request_turns.hpp"

#include <algorithm>
#include <utility>

namespace ovws {
namespace {

constexpr std::size_t kOverheadBytes = 256;  // memory of one request besides its bytes

}  // namespace

std::size_t Request::size() const {
  std::size_t size =
      kOverheadBytes + body.bytes.size() + body.binary.size() + body.client_key.size();
  for (const std::string& frame : envelope) size += frame.size();
  return size;
}

std::shared_ptr<ClientLoad> RequestTurns::load_of(const std::string& routing_id) {
  if (clients_.size() >= sweep_at_) remove_idle_clients();
  return clients_[routing_id].load;
}

bool RequestTurns::push(Request request) {
  const std::size_t size = request.size();
  if (clients_.size() >= sweep_at_) remove_idle_clients();
  Client& client = clients_[request.envelope.front()];
  const bool fits = waiting_bytes_ + size <= kMaxTotalBytes;
  const bool own_fits = client.waiting_bytes + size <= kMaxClientBytes;
  const bool has_binary = !request.body.binary.empty();
  const bool allowed =
      client.waiting.empty() ? fits || !has_binary || waiting_bytes_ == 0 : fits && own_fits;
  if (!allowed) return false;
  if (client.waiting.empty()) turns_.push_back(&client);
  client.waiting.push_back(std::move(request));
  client.waiting_bytes += size;
  waiting_bytes_ += size;
  return true;
}

std::optional<RequestTurns::Turn> RequestTurns::next() {
  for (std::size_t tries = turns_.size(); tries > 0; --tries) {
    Client& client = *turns_.front();
    turns_.pop_front();
    const bool with_binary = !client.waiting.front().body.binary.empty();
    if (!box_->has_room(*client.load, with_binary)) {
      turns_.push_back(&client);
      continue;
    }
    Turn turn{std::move(client.waiting.front()), client.load};
    client.waiting.pop_front();
    client.waiting_bytes -= turn.request.size();
    waiting_bytes_ -= turn.request.size();
    if (!client.waiting.empty()) turns_.push_back(&client);
    return turn;
  }
  return std::nullopt;
}

/// Removes idle clients, because clients leave without notice. The table is swept when it has
/// doubled, so the cost per request is constant on average.
void RequestTurns::remove_idle_clients() {
  constexpr std::size_t kMinSweep = 64;
  std::erase_if(clients_, [this](const auto& entry) {
    return entry.second.waiting.empty() && box_->is_idle(*entry.second.load);
  });
  sweep_at_ = std::max(kMinSweep, 2 * clients_.size());
}

}  // namespace ovws
