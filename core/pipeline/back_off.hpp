/// Exponential backoff, counted in calls: an expensive operation that fails is tried at the first
/// call, then after 1, 2, 4, 8, 16, 16, … more calls.
#pragma once

#include <algorithm>

namespace ovws {

class BackOff {
 public:
  static constexpr int kMaxGap = 16;

  /// Call it whenever the operation is needed. Returns true if the operation shall be tried now.
  bool try_now() {
    if (wait_ > 0) {
      --wait_;
      return false;
    }
    wait_ = gap_ - 1;
    gap_ = std::min(2 * gap_, kMaxGap);
    return true;
  }

  /// Call it when the operation is not needed at present: the next try_now returns true.
  void reset() {
    wait_ = 0;
    gap_ = 1;
  }

 private:
  int wait_ = 0;
  int gap_ = 1;
};

}  // namespace ovws
