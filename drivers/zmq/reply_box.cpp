#include "drivers/zmq/reply_box.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

namespace ovws {
namespace {

bool idle(const ClientLoad& load) {
  return load.requests == 0 && load.replies == 0;
}

bool within(const ClientLoad& load, const ClientLoad& limit) {
  return load.requests < limit.requests && load.request_bytes < limit.request_bytes &&
         load.replies < limit.replies && load.reply_bytes < limit.reply_bytes;
}

}  // namespace

/// State shared by all copies of one reply function. If the last copy is destroyed unanswered, the
/// request no longer counts as outstanding.
class ReplyBox::Ticket {
 public:
  Ticket(std::shared_ptr<ReplyBox> box, Envelope envelope, std::shared_ptr<ClientLoad> client,
         std::size_t request_bytes)
      : box_(std::move(box)),
        envelope_(std::move(envelope)),
        client_(std::move(client)),
        request_bytes_(request_bytes) {}
  Ticket(const Ticket&) = delete;
  Ticket& operator=(const Ticket&) = delete;
  ~Ticket() { reply({}, nullptr); }

  void reply(std::string bytes, std::shared_ptr<const std::string> binary) {
    if (used_.exchange(true)) return;
    box_->put({std::move(envelope_), std::move(bytes), std::move(binary), std::move(client_)},
              request_bytes_);
  }

 private:
  std::shared_ptr<ReplyBox> box_;
  Envelope envelope_;
  std::shared_ptr<ClientLoad> client_;
  std::size_t request_bytes_;
  std::atomic<bool> used_{false};
};

ReplyBox::ReplyBox() : wake_fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

ReplyBox::~ReplyBox() {
  ::close(wake_fd_);
}

SendReply ReplyBox::reply_to(Envelope envelope, std::shared_ptr<ClientLoad> client,
                             std::size_t request_bytes) {
  ClientLoad& own = *client;
  auto ticket = std::make_shared<Ticket>(shared_from_this(), std::move(envelope), std::move(client),
                                         request_bytes);
  {
    const std::lock_guard lock(mutex_);
    change(own, {1, request_bytes}, {});
  }
  return [ticket](std::string bytes, std::shared_ptr<const std::string> binary) {
    ticket->reply(std::move(bytes), std::move(binary));
  };
}

bool ReplyBox::has_room(const ClientLoad& client, bool with_binary) {
  const std::lock_guard lock(mutex_);
  const bool allowed =
      idle(client) || (within(client, kMaxPerClient) && within(all_, kMaxAllClients));
  const bool room = allowed && (!with_binary || all_.request_bytes < kMaxBinaryRequestBytes);
  if (!room) request_waits_ = true;
  return room;
}

bool ReplyBox::can_refuse(const ClientLoad& client) const {
  const std::lock_guard lock(mutex_);
  return client.replies < kMaxRefusals && all_.replies < kMaxAllClients.replies;
}

bool ReplyBox::is_idle(const ClientLoad& client) const {
  const std::lock_guard lock(mutex_);
  return idle(client);
}

std::vector<ReplyBox::Reply> ReplyBox::collect() {
  std::uint64_t count = 0;
  while (::read(wake_fd_, &count, sizeof count) < 0 && errno == EINTR) {
  }
  const std::lock_guard lock(mutex_);
  return std::exchange(replies_, {});
}

void ReplyBox::sent(ClientLoad& client, std::size_t reply_bytes) {
  bool waits = false;
  {
    const std::lock_guard lock(mutex_);
    change(client, {}, {0, 0, 1, reply_bytes});
    waits = std::exchange(request_waits_, false);
  }
  if (waits) wake();
}

void ReplyBox::put(Reply reply, std::size_t request_bytes) {
  {
    const std::lock_guard lock(mutex_);
    const std::size_t replies = reply.bytes.empty() ? 0 : 1;
    change(*reply.client, {0, 0, replies, reply.size()}, {1, request_bytes});
    if (replies > 0) replies_.push_back(std::move(reply));
  }
  wake();
}

void ReplyBox::change(ClientLoad& client, const ClientLoad& begun, const ClientLoad& ended) {
  for (ClientLoad* load : {&client, &all_}) {
    load->requests += begun.requests - ended.requests;
    load->request_bytes += begun.request_bytes - ended.request_bytes;
    load->replies += begun.replies - ended.replies;
    load->reply_bytes += begun.reply_bytes - ended.reply_bytes;
  }
}

void ReplyBox::wake() const {
  const std::uint64_t one = 1;
  while (::write(wake_fd_, &one, sizeof one) < 0 && errno == EINTR) {
  }
}

}  // namespace ovws
