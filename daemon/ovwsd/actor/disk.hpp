/// The disk thread's agent: runs blocking disk work for the other threads.
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

  /// From now on tasks are queued for the disk thread, which is started next.
  void begin() { begun_.store(true); }
  /// Thread-safe. The disk thread runs tasks in order, and the caller does not wait. Before begin
  /// (at start-up, and in tests) a task runs at once, in the calling thread.
  void post(Task task);
  /// The same for a client's request. Errc::unavailable if kMaxRequests are queued already.
  Result<void> request(Task task);
  /// Call before the thread starts: `work` runs each turn, and again at once while it returns true.
  void each_turn(std::function<bool()> work) { work_ = std::move(work); }

  bool do_work() override;
  /// Runs all tasks posted so far; later ones are dropped.
  void on_close() override;

 private:
  std::atomic<bool> begun_{false};
  std::atomic<int> requests_{0};
  Mailbox mailbox_;
  std::function<bool()> work_;
  bool more_ = false;
};

}  // namespace ovws
