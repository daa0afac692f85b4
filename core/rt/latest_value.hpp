/// Triple buffer: hands the newest value from one writer thread to one reader thread.
#pragma once

#include <array>
#include <atomic>
#include <utility>

#include "core/base/realtime.hpp"

namespace ovws {

/// Wait-free triple buffer for one writer and one reader thread. A new value overwrites an unread
/// one. RT-safe if moving a T does not allocate memory.
template <class T>
class LatestValue {
 public:
  LatestValue() = default;
  explicit LatestValue(const T& initial) : buffers_{initial, initial, initial} {}

  /// Writer thread: publishes `value` as the newest value.
  void write(T value) OVWS_NONBLOCKING {
    buffers_[back_] = std::move(value);
    const unsigned previous = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel);
    back_ = previous & kIndex;
  }

  /// Reader thread: takes the newest value; false if there is none since the last call.
  bool update() OVWS_NONBLOCKING {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader thread: the value that update() took last; before that, the initial value.
  const T& value() const { return buffers_[front_]; }
  T& value() { return buffers_[front_]; }

 private:
  static constexpr unsigned kIndex = 3;
  static constexpr unsigned kFresh = 4;
  std::array<T, 3> buffers_{};
  unsigned back_ = 0;
  std::atomic<unsigned> middle_{1};
  unsigned front_ = 2;
};

}  // namespace ovws
