/// Queue of replies from any thread to the control thread, with accounting of each client's
/// outstanding requests and replies (backpressure). Private to this driver.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/zmq/send_reply.hpp"

namespace ovws {

/// Routing frames of a request, which lead the reply to the client. The client's routing id is
/// first.
using Envelope = std::vector<std::string>;

/// Outstanding requests and replies of one client. Guarded by the mutex of the ReplyBox.
struct ClientLoad {
  std::size_t requests = 0, request_bytes = 0;  ///< requests being carried out
  std::size_t replies = 0, reply_bytes = 0;     ///< not yet written to the client's connection
};

/// Limits per client: requests, their bytes, replies, their bytes. At a limit the next request
/// waits.
constexpr ClientLoad kMaxPerClient{64, 8 << 10, 128, 4 << 20};
/// Limits of all clients together. At a limit only clients with nothing outstanding are served.
constexpr ClientLoad kMaxAllClients{128, 1 << 20, 16384, 32 << 20};

/// Limit of the bytes of all requests being carried out at which a request with a binary frame
/// waits, also that of a client with nothing outstanding.
constexpr std::size_t kMaxBinaryRequestBytes = 32 << 20;

/// Limit of a client's unread replies. At this limit, or at the limit of all clients' replies, a
/// request that cannot be queued gets no reply.
constexpr std::size_t kMaxRefusals = 1024;

/// Reply queue, kept alive by the server, by reply functions and by unsent replies. After the
/// server is destroyed, replies are discarded.
class ReplyBox : public std::enable_shared_from_this<ReplyBox> {
 public:
  struct Reply {
    Envelope envelope;
    std::string bytes;
    std::shared_ptr<const std::string> binary;  ///< null: none
    std::shared_ptr<ClientLoad> client;
    std::size_t size() const { return bytes.size() + (binary ? binary->size() : 0); }
  };

  ReplyBox();
  ~ReplyBox();
  ReplyBox(const ReplyBox&) = delete;
  ReplyBox& operator=(const ReplyBox&) = delete;

  /// eventfd that wakes the control thread: readable while replies wait for `collect`, and once
  /// when a load has decreased after has_room returned false.
  int wake_fd() const { return wake_fd_; }
  /// Makes the reply function of one request of `request_bytes` bytes. The first call of the
  /// function queues the reply in this box; later calls do nothing. Thread-safe.
  SendReply reply_to(Envelope envelope, std::shared_ptr<ClientLoad> client,
                     std::size_t request_bytes);
  /// Whether the limits allow a further request of the client, with a binary frame or without.
  /// Thread-safe.
  bool has_room(const ClientLoad& client, bool with_binary = false);
  /// Whether a request of the client that cannot be queued may still be answered with an error.
  /// Thread-safe.
  bool can_refuse(const ClientLoad& client) const;
  /// Whether the client has no outstanding request and no outstanding reply. Thread-safe.
  bool is_idle(const ClientLoad& client) const;
  /// Takes all queued replies. A reply counts as outstanding until `sent`. Control thread only.
  std::vector<Reply> collect();
  /// Notes that a collected reply was written to the connection or dropped. Thread-safe.
  void sent(ClientLoad& client, std::size_t reply_bytes);

 private:
  class Ticket;
  /// Ends a request and queues its reply; an empty reply is not sent.
  void put(Reply reply, std::size_t request_bytes);
  /// Adds `begun` to the load of the client and to the total load, and subtracts `ended`. The
  /// caller holds the mutex.
  void change(ClientLoad& client, const ClientLoad& begun, const ClientLoad& ended);
  void wake() const;

  mutable std::mutex mutex_;
  std::vector<Reply> replies_;
  ClientLoad all_;
  bool request_waits_ = false;  ///< has_room was false; `sent` must wake the thread
  int wake_fd_ = -1;
};

}  // namespace ovws
