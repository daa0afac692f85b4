/// The disk thread's agent: other threads hand it what has to wait for a disk, and go on.
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
  /// Requests of clients that may wait at once: a disk that stands still must not fill the memory.
  static constexpr int kMaxRequests = 64;

  /// From now on tasks wait for the disk thread, which is about to be made.
  void begin() { begun_.store(true); }
  /// Thread-safe, never waits for the disk. Tasks are carried out in order, in the disk thread;
  /// before begin (at the start, and in tests) at once, in the calling thread.
  void post(Task task);
  /// The same for a client's request. Errc::unavailable if too many wait already.
  Result<void> request(Task task);
  /// Before the thread begins: `work` is called each turn, and again at once while it returns true.
  void each_turn(std::function<bool()> work) { work_ = std::move(work); }

  bool do_work() override;
  /// Carries out what was posted by then.
  void on_close() override;

 private:
  std::atomic<bool> begun_{false};
  std::atomic<int> requests_{0};
  Mailbox mailbox_;
  std::function<bool()> work_;
  bool more_ = false;
};

}  // namespace ovws
