/// SPSC ring buffer: a bounded queue between two threads, over moodycamel's circular buffer.
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>
#include <semaphore.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>

#include "core/base/realtime.hpp"

namespace ovws {

/// Queue for one producer and one consumer thread at a time. Another thread may take over as
/// producer or consumer if the caller synchronises the change. Only the constructor allocates.
template <class T>
class SpscRing {
 public:
  explicit SpscRing(std::size_t capacity) : buffer_(capacity) { sem_init(&pushed_, 0, 0); }
  ~SpscRing() { sem_destroy(&pushed_); }
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Appends an item; false if the ring is full and nothing was appended. RT-safe.
  [[nodiscard]] bool try_push(const T& item) OVWS_NONBLOCKING {
    if (!buffer_.try_enqueue(item)) return false;
    sem_post(&pushed_);
    return true;
  }

  /// Removes the oldest item; false if the ring is empty. RT-safe.
  [[nodiscard]] bool try_pop(T& item) OVWS_NONBLOCKING {
    if (!buffer_.try_dequeue(item)) return false;
    sem_trywait(&pushed_);  // stops the semaphore from growing while pop never waits
    return true;
  }

  /// Removes the oldest item, waiting for it at most `timeout`; false if no item arrived.
  [[nodiscard]] bool pop(T& item, std::chrono::microseconds timeout) {
    if (try_pop(item)) return true;
    const timespec until = after(timeout);
    // moodycamel's timed wait uses CLOCK_REALTIME: setting that clock back would block the thread.
    // A semaphore post whose item was already popped only costs one more iteration.
    while (sem_clockwait(&pushed_, CLOCK_MONOTONIC, &until) == 0) {
      if (try_pop(item)) return true;
    }
    return try_pop(item);
  }

  std::size_t size_approx() const { return buffer_.size_approx(); }

 private:
  static timespec after(std::chrono::microseconds timeout) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    timespec now{};  // the kernel's, which knows of no skipped time
    clock_gettime(CLOCK_MONOTONIC, &now);
    const std::int64_t until_ns = now.tv_nsec + std::chrono::nanoseconds(timeout).count();
    return {now.tv_sec + std::time_t(until_ns / kSecond), long(until_ns % kSecond)};
  }

  moodycamel::BlockingReaderWriterCircularBuffer<T> buffer_;
  sem_t pushed_{};
};

}  // namespace ovws
