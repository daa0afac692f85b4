/// An actor's mailbox: a queue of tasks from other threads that one thread runs in order.
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

  /// Owner's thread: drops the queued tasks, and refuses new ones.
  void close() {
    std::deque<Task> dropped;  // destroyed without the lock: a destructor may notify the sender
    const std::lock_guard lock(mutex_);
    closed_ = true;
    dropped.swap(tasks_);
  }

  /// Owner's thread: waits at most `timeout` for a task, and runs it. False if none came.
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
