/// Round-robin scheduling of requests over clients, with a limit on the queued bytes. Private to
/// this driver.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "drivers/zmq/control_server.hpp"
#include "drivers/zmq/reply_box.hpp"

namespace ovws {

/// One received request.
struct Request {
  Envelope envelope;
  ControlRequest body;
  bool well_sized = true;    ///< false: too large or too many frames; the body has no bytes
  std::size_t size() const;  ///< memory use, bytes
};

/// Queue of requests until their client has room in the ReplyBox. Control thread only.
class RequestTurns {
 public:
  explicit RequestTurns(std::shared_ptr<ReplyBox> box) : box_(std::move(box)) {}

  /// Limits of the queued requests in bytes, per client and in total. A client without a queued
  /// request may always queue one; one with a binary frame only within the total, or if nothing
  /// else is queued.
  static constexpr std::size_t kMaxClientBytes = 8 << 20;
  static constexpr std::size_t kMaxTotalBytes = 32 << 20;

  /// The load of the client with this routing id; created if new.
  std::shared_ptr<ClientLoad> load_of(const std::string& routing_id);
  /// Queues a request. False if a limit is reached; the request is then discarded.
  bool push(Request request);

  struct Turn {
    Request request;
    std::shared_ptr<ClientLoad> client;
  };
  /// Takes the next request in round-robin order: from the first client in turn that has room in
  /// the ReplyBox. Requests of one client keep their order. None if no client with a queued request
  /// has room.
  std::optional<Turn> next();

 private:
  struct Client {
    std::deque<Request> waiting;
    std::size_t waiting_bytes = 0;
    std::shared_ptr<ClientLoad> load = std::make_shared<ClientLoad>();
  };
  void remove_idle_clients();

  std::shared_ptr<ReplyBox> box_;
  std::unordered_map<std::string, Client> clients_;  ///< by routing id
  std::deque<Client*> turns_;  ///< clients with queued requests; map nodes do not move
  std::size_t waiting_bytes_ = 0;
  std::size_t sweep_at_ = 64;  ///< number of clients that triggers remove_idle_clients
};

}  // namespace ovws
