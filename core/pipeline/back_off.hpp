/// How often something dear that fails may be tried: at once, then after 1, 2, 4, 8, 16, 16, …
/// chances.
#pragma once

#include <algorithm>

namespace ovws {

class BackOff {
 public:
  static constexpr int kLongestGap = 16;

  /// A chance to try: true if it is to be taken.
  bool try_now() {
    if (wait_ > 0) {
      --wait_;
      return false;
    }
    wait_ = gap_ - 1;
    gap_ = std::min(2 * gap_, kLongestGap);
    return true;
  }

  /// All is well without trying: the next need is tried at once.
  void reset() {
    wait_ = 0;
    gap_ = 1;
  }

 private:
  int wait_ = 0;
  int gap_ = 1;
};

}  // namespace ovws
