/// Replies on their way from any thread to the control thread. Private to this driver.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace ovws {

/// Frames that lead back to the asker, its routing id first.
using Envelope = std::vector<std::string>;

/// Outlives its server for as long as somebody holds a reply function; then replies go nowhere.
class ReplyBox : public std::enable_shared_from_this<ReplyBox> {
 public:
  ReplyBox();
  ~ReplyBox();
  ReplyBox(const ReplyBox&) = delete;
  ReplyBox& operator=(const ReplyBox&) = delete;

  /// Readable while there is something to collect.
  int wake_fd() const { return wake_fd_; }
  /// A function for one request: its first call puts the reply here, later ones do nothing.
  /// Thread-safe.
  std::function<void(std::string)> reply_to(Envelope envelope);
  /// Requests whose reply was not collected yet. Thread-safe.
  std::size_t pending() const;
  /// Takes all replies that are there. Control thread.
  std::vector<std::pair<Envelope, std::string>> collect();

 private:
  class Ticket;
  void put(Envelope envelope, std::string reply);
  void forget();
  void wake() const;

  mutable std::mutex mutex_;
  std::vector<std::pair<Envelope, std::string>> replies_;
  std::size_t pending_ = 0;
  int wake_fd_ = -1;
};

}  // namespace ovws
