/// The files that a job's results are written to, and that the disk has not answered for yet.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace ovws {

/// Thread-safe.
class PendingFiles : public std::enable_shared_from_this<PendingFiles> {
 public:
  /// A file is pending as long as the token lives: it belongs to the callback that is called when
  /// the disk has answered, so that it ends with that callback, called or not.
  std::shared_ptr<void> add() {
    {
      const std::lock_guard lock(mutex_);
      ++count_;
    }
    return {nullptr, [self = shared_from_this()](void*) { self->end_one(); }};
  }
  /// False: some are still pending.
  bool wait_for(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return none_.wait_for(lock, patience, [this] { return count_ == 0; });
  }
  /// Calls `then` once when none is pending: now, or in the thread that ends the last one.
  void when_none(std::function<void()> then) {
    {
      const std::lock_guard lock(mutex_);
      if (count_ > 0) {
        then_ = std::move(then);
        return;
      }
    }
    then();
  }

 private:
  void end_one() {
    std::function<void()> then;
    {
      const std::lock_guard lock(mutex_);
      if (--count_ == 0) then = std::exchange(then_, nullptr);
    }
    none_.notify_all();
    if (then) then();
  }

  std::mutex mutex_;
  std::condition_variable none_;
  int count_ = 0;
  std::function<void()> then_;
};

}  // namespace ovws
