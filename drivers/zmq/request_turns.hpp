/// Round-robin scheduling of requests over clients, with a bound in bytes on what waits. Private to
/// this driver.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "drivers/zmq/reply_box.hpp"

namespace ovws {

/// One request as it came in.
struct Request {
  Envelope envelope;
  std::string bytes;
  std::string asker;         ///< the client's public key, or empty
  bool well_sized = true;    ///< false: it is answered with an error and `bytes` is empty
  std::size_t size() const;  ///< what it takes in memory
};

/// Requests that wait until their client has room for them in the ReplyBox. Control thread only.
class RequestTurns {
 public:
  explicit RequestTurns(std::shared_ptr<ReplyBox> box) : box_(std::move(box)) {}

  /// What waits of one client, and of all. A client of which nothing waits may always add one.
  static constexpr std::size_t kMostOfOneBytes = 8 << 20;
  static constexpr std::size_t kMostOfAllBytes = 32 << 20;

  /// The load of the client with this routing id, made if there is none.
  std::shared_ptr<ClientLoad> load_of(const std::string& routing_id);
  /// False: too much waits, and the request was not taken.
  bool push(Request request);

  struct Turn {
    Request request;
    std::shared_ptr<ClientLoad> client;
  };
  /// The next request: of the client that has waited longest for its turn and has room. Requests of
  /// one client keep their order. None if no client with a waiting request has room.
  std::optional<Turn> next();

 private:
  struct Client {
    std::deque<Request> waiting;
    std::size_t waiting_bytes = 0;
    std::shared_ptr<ClientLoad> load = std::make_shared<ClientLoad>();
  };
  void forget_idle_clients();

  std::shared_ptr<ReplyBox> box_;
  std::unordered_map<std::string, Client> clients_;  ///< by routing id
  std::deque<Client*> turns_;  ///< clients of which something waits; a map's nodes do not move
  std::size_t waiting_bytes_ = 0;
  std::size_t sweep_at_ = 64;  ///< clients
};

}  // namespace ovws
