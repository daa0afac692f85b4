/// A value that several threads outside the frame path share: copied in and out under a lock.
#pragma once

#include <mutex>
#include <utility>

namespace ovws {

/// Thread-safe. T is copied whole, so that nobody sees half a change.
template <class T>
class Guarded {
 public:
  Guarded() = default;
  explicit Guarded(T value) : value_(std::move(value)) {}

  T get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }
  void set(T value) {
    const std::lock_guard lock(mutex_);
    value_ = std::move(value);
  }
  template <class Change>
  auto change(Change change) {
    const std::lock_guard lock(mutex_);
    return change(value_);
  }

 private:
  mutable std::mutex mutex_;
  T value_{};
};

}  // namespace ovws
