/// Exponential backoff, counted in calls: an expensive operation that fails is tried at the first
/// call, then after 1, 2, 4, 8, 16, 16, … more calls.
#pragma once

#include <algorithm>

namespace ovws {

class BackOff {
 public:
  static constexpr int kMaxGap = 16;

  /// Called whenever the operation is needed; true if it shall be tried now.
  bool try_now() {
    if (wait_ > 0) {
      --wait_;
      return false;
    }
    wait_ = gap_ - 1;
    gap_ = std::min(2 * gap_, kMaxGap);
    return true;
  }

  /// The operation is not needed at present: the next call of try_now returns true.
  void reset() {
    wait_ = 0;
    gap_ = 1;
  }

 private:
  int wait_ = 0;
  int gap_ = 1;
};

}  // namespace ovws
