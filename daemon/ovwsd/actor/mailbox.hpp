/// A queue of tasks that one thread carries out in order: how other threads ask an actor for
/// something.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>

namespace ovws {

/// Not for the frame path: it locks and allocates.
class Mailbox {
 public:
  using Task = std::function<void()>;

  /// Thread-safe.
  void post(Task task) {
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return;
      tasks_.push_back(std::move(task));
    }
    ready_.notify_one();
  }

  /// The owner's thread: forgets what waits, and takes nothing more.
  void close() {
    std::deque<Task> forgotten;  // destroyed without the lock: a task may tell who asked for it
    const std::lock_guard lock(mutex_);
    closed_ = true;
    forgotten.swap(tasks_);
  }

  /// The owner's thread: runs one task; waits for it at most `timeout`. False if there was none.
  bool run_one(std::chrono::milliseconds timeout) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      if (!ready_.wait_for(lock, timeout, [this] { return !tasks_.empty(); })) return false;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
    return true;
  }

 private:
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<Task> tasks_;
  bool closed_ = false;
};

}  // namespace ovws
