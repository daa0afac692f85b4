/// Replies on their way from any thread to the control thread, and what each client has
/// outstanding. Private to this driver.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace ovws {

/// Frames that lead back to the asker, its routing id first.
using Envelope = std::vector<std::string>;

/// What one client has outstanding. Owned by the ReplyBox, whose lock guards it.
struct ClientLoad {
  std::size_t requests = 0, request_bytes = 0;  ///< handed on, not yet answered
  std::size_t replies = 0, reply_bytes = 0;     ///< answered, not yet written to its connection
};

/// Limits of what is outstanding: beyond, a client's next request waits.
constexpr ClientLoad kMostOfOneClient{64, 8 << 10, 128, 4 << 20};
/// Of all clients together; beyond, only a client with nothing outstanding is served.
constexpr ClientLoad kMostOfAllClients{128, 1 << 20, 16384, 32 << 20};

/// Beyond so many replies that a client has not read, further refusals to it are dropped.
constexpr std::size_t kMaxRefusals = 1024;

/// Outlives its server for as long as a reply function or an unsent reply exists; then replies go
/// nowhere.
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

  /// Readable while there is something to collect, and once after has_room was false and a load
  /// became less.
  int wake_fd() const { return wake_fd_; }
  /// A function for one request of `request_bytes`: its first call puts the reply here, later ones
  /// do nothing. Thread-safe.
  std::function<void(std::string)> reply_to(Envelope envelope, std::shared_ptr<ClientLoad> client,
                                            std::size_t request_bytes);
  /// Whether the limits above admit a further request of the client. Thread-safe.
  bool has_room(const ClientLoad& client);
  /// Whether a request of the client that cannot wait may still be answered by an error.
  /// Thread-safe.
  bool can_refuse(const ClientLoad& client) const;
  /// Whether the client has nothing outstanding. Thread-safe.
  bool is_idle(const ClientLoad& client) const;
  /// Takes all replies that are there. They count as outstanding until `sent`. Control thread.
  std::vector<Reply> collect();
  /// A collected reply was written to the connection, or dropped. Thread-safe.
  void sent(ClientLoad& client, std::size_t reply_bytes);

 private:
  class Ticket;
  void put(Reply reply, std::size_t request_bytes);
  void forget(ClientLoad& client, std::size_t request_bytes);
  void wake() const;

  mutable std::mutex mutex_;
  std::vector<Reply> replies_;
  ClientLoad all_;
  bool one_waits_ = false;  ///< a request waits for has_room
  int wake_fd_ = -1;
};

}  // namespace ovws
