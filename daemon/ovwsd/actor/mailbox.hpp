/// An actor's mailbox: a queue of tasks from other threads that one thread runs in order.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <utility>

namespace ovws {

/// Task queue with a mutex. Do not use it in the frame path: it locks and allocates.
class Mailbox {
 public:
  using Task = std::function<void()>;

  /// Queues a task, or drops it after `close`. Thread-safe.
  void post(Task task) {
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return;
      tasks_.push_back(std::move(task));
    }
    ready_.notify_one();
  }

  /// Drops the queued tasks, and from now on drops new tasks. Owner's thread only.
  void close() {
    std::deque<Task> dropped;  // destroyed after the unlock: a destructor may notify a sender
    const std::lock_guard lock(mutex_);
    closed_ = true;
    dropped.swap(tasks_);
  }

  /// Waits at most `timeout` for a task and runs it; false if no task came. Owner's thread only.
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
