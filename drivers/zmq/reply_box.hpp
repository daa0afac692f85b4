/// Queue of replies from any thread to the control thread, with accounting of each client's
/// outstanding requests and replies (backpressure). Private to this driver.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace ovws {

/// Routing frames that lead back to the client, its routing id first.
using Envelope = std::vector<std::string>;

/// Outstanding requests and replies of one client. Guarded by the lock of the ReplyBox.
struct ClientLoad {
  std::size_t requests = 0, request_bytes = 0;  ///< being carried out, not yet answered
  std::size_t replies = 0, reply_bytes = 0;     ///< answered, not yet written to its connection
};

/// Limits per client; beyond them its next request waits.
constexpr ClientLoad kMaxPerClient{64, 8 << 10, 128, 4 << 20};
/// Limits of all clients together; beyond them only a client with nothing outstanding is served.
constexpr ClientLoad kMaxAllClients{128, 1 << 20, 16384, 32 << 20};

/// Limit of a client's unread replies, beyond which further refusals to it are dropped.
constexpr std::size_t kMaxRefusals = 1024;

/// Lives as long as a reply function or an unsent reply exists, even after its server; replies are
/// then discarded.
class ReplyBox : public std::enable_shared_from_this<ReplyBox> {
 public:
  struct Reply {
    Envelope envelope;
    std::string bytes;
    std::shared_ptr<ClientLoad> client;
  };

  ReplyBox();
  ~ReplyBox();
  ReplyBox(const ReplyBox&) = delete;
  ReplyBox& operator=(const ReplyBox&) = delete;

  /// eventfd, readable while there are replies to collect, and once when a load has decreased after
  /// has_room was false.
  int wake_fd() const { return wake_fd_; }
  /// Makes the reply function of one request of `request_bytes`. Its first call queues the reply
  /// here, later ones do nothing. Thread-safe.
  std::function<void(std::string)> reply_to(Envelope envelope, std::shared_ptr<ClientLoad> client,
                                            std::size_t request_bytes);
  /// Whether the limits admit a further request of the client. Thread-safe.
  bool has_room(const ClientLoad& client);
  /// Whether a request of the client that cannot be queued may still be answered with an error.
  /// Thread-safe.
  bool can_refuse(const ClientLoad& client) const;
  /// Whether the client has nothing outstanding. Thread-safe.
  bool is_idle(const ClientLoad& client) const;
  /// Takes all queued replies. They count as outstanding until `sent`. Control thread.
  std::vector<Reply> collect();
  /// Notes that a collected reply was written to the connection or dropped. Thread-safe.
  void sent(ClientLoad& client, std::size_t reply_bytes);

 private:
  class Ticket;
  /// Ends a request; an empty reply is not sent.
  void put(Reply reply, std::size_t request_bytes);
  /// Changes the load of the client and of all by what began and what ended. With the lock.
  void change(ClientLoad& client, const ClientLoad& begun, const ClientLoad& ended);
  void wake() const;

  mutable std::mutex mutex_;
  std::vector<Reply> replies_;
  ClientLoad all_;
  bool request_waits_ = false;  ///< a request waits for has_room
  int wake_fd_ = -1;
};

}  // namespace ovws
