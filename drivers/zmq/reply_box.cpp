#include "drivers/zmq/reply_box.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>

namespace ovws {

/// Shared by all copies of one reply function; the last one to go unanswered gives the place free.
class ReplyBox::Ticket {
 public:
  Ticket(std::shared_ptr<ReplyBox> box, Envelope envelope)
      : box_(std::move(box)), envelope_(std::move(envelope)) {}
  Ticket(const Ticket&) = delete;
  Ticket& operator=(const Ticket&) = delete;
  ~Ticket() {
    if (!used_.exchange(true)) box_->forget();
  }

  void reply(std::string bytes) {
    if (used_.exchange(true)) return;
    if (bytes.empty()) return box_->forget();
    box_->put(std::move(envelope_), std::move(bytes));
  }

 private:
  std::shared_ptr<ReplyBox> box_;
  Envelope envelope_;
  std::atomic<bool> used_{false};
};

ReplyBox::ReplyBox() : wake_fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

ReplyBox::~ReplyBox() {
  ::close(wake_fd_);
}

std::function<void(std::string)> ReplyBox::reply_to(Envelope envelope) {
  auto ticket = std::make_shared<Ticket>(shared_from_this(), std::move(envelope));
  const std::lock_guard lock(mutex_);
  ++pending_;
  return [ticket](std::string bytes) { ticket->reply(std::move(bytes)); };
}

std::size_t ReplyBox::pending() const {
  const std::lock_guard lock(mutex_);
  return pending_;
}

std::vector<std::pair<Envelope, std::string>> ReplyBox::collect() {
  std::uint64_t count = 0;
  while (::read(wake_fd_, &count, sizeof count) < 0 && errno == EINTR) {
  }
  const std::lock_guard lock(mutex_);
  pending_ -= replies_.size();
  return std::exchange(replies_, {});
}

void ReplyBox::put(Envelope envelope, std::string reply) {
  {
    const std::lock_guard lock(mutex_);
    replies_.emplace_back(std::move(envelope), std::move(reply));
  }
  wake();
}

void ReplyBox::forget() {
  {
    const std::lock_guard lock(mutex_);
    --pending_;
  }
  wake();
}

void ReplyBox::wake() const {
  const std::uint64_t one = 1;
  while (::write(wake_fd_, &one, sizeof one) < 0 && errno == EINTR) {
  }
}

}  // namespace ovws
