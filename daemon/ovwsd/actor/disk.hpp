/// Agent of the disk thread: runs blocking disk work for other threads.
#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "core/base/result.hpp"
#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"

namespace ovws {

class Disk : public Agent {
 public:
  using Task = std::function<void()>;
  /// Limit of queued client requests: a disk that does not answer must not fill the memory.
  static constexpr int kMaxRequests = 64;

  /// Queues tasks for the disk thread from now on. Call this just before the disk thread starts.
  void begin() { begun_.store(true); }
  /// Queues a task; the disk thread runs tasks in order, and the caller does not wait. Before
  /// `begin` (at start-up and in tests), the task runs at once in the calling thread. Thread-safe.
  void post(Task task);
  /// Queues a task for a client's request. Errc::unavailable if kMaxRequests are already queued.
  Result<void> request(Task task);
  /// Sets the work for each turn of the disk thread. `work` is repeated at once while it returns
  /// true. Call this before the thread starts.
  void each_turn(std::function<bool()> work) { work_ = std::move(work); }

  bool do_work() override;
  /// Runs all tasks posted so far; drops tasks that are posted later.
  void on_close() override;

 private:
  std::atomic<bool> begun_{false};
  std::atomic<int> requests_{0};
  Mailbox mailbox_;
  std::function<bool()> work_;
  bool more_ = false;
};

}  // namespace ovws
