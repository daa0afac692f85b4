/// Mutex-protected value for threads outside the frame path.
#pragma once

#include <mutex>
#include <utility>

namespace ovws {

/// Thread-safe. Copies T as a whole, so that readers never see a partial change.
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
  /// Calls `change` with the value and returns its result. The call runs under the lock: it must
  /// not call get, set or change of this object.
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
