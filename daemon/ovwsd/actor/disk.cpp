#include "daemon/ovwsd/actor/disk.hpp"

#include <memory>

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kIdle{50};
constexpr std::chrono::milliseconds kNow{0};

}  // namespace

void Disk::post(Task task) {
  if (!begun_.load()) return task();
  mailbox_.post(std::move(task));
}

Result<void> Disk::request(Task task) {
  if (requests_.fetch_add(1) >= kMaxRequests) {
    requests_.fetch_sub(1);
    return fail(Errc::unavailable, "",
                "too many requests already wait for the disk: see `store` of system.status");
  }
  // The request counts until its task has run or is dropped when the mailbox closes.
  std::shared_ptr<void> counted(nullptr, [this](void*) { requests_.fetch_sub(1); });
  post([task = std::move(task), counted = std::move(counted)] { task(); });
  return {};
}

bool Disk::do_work() {
  const bool worked = mailbox_.run_one(more_ ? kNow : kIdle);
  more_ = work_ && work_();
  return worked || more_;
}

void Disk::on_close() {
  while (mailbox_.run_one(kNow)) {
  }
  while (work_ && work_()) {
  }
  mailbox_.close();
}

}  // namespace ovws
