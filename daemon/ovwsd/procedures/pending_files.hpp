/// Counts a job's files whose writing has not finished.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace ovws {

/// Counter of files that are still being written. Thread-safe.
class PendingFiles : public std::enable_shared_from_this<PendingFiles> {
 public:
  /// Adds a pending file and returns its token; the file is pending until the token is destroyed.
  /// Store the token in the write's completion callback, so that it is released even if the
  /// callback is never called.
  std::shared_ptr<void> add() {
    {
      const std::lock_guard lock(mutex_);
      ++count_;
    }
    return {nullptr, [self = shared_from_this()](void*) { self->end_one(); }};
  }
  /// Waits until no file is pending. Returns false if files are still pending after `patience`.
  bool wait_for(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return none_.wait_for(lock, patience, [this] { return count_ == 0; });
  }
  /// Calls `then` exactly once, as soon as no file is pending: now, or later in the thread that
  /// releases the last token.
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
