/// Exponential backoff: an operation that keeps failing is tried less often, down to every 16th
/// call.
#include "core/pipeline/back_off.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ovws {
namespace {

std::vector<int> tries(BackOff& back_off, int chances) {
  std::vector<int> at;
  for (int i = 0; i < chances; ++i) {
    if (back_off.try_now()) at.push_back(i);
  }
  return at;
}

TEST(BackOff, IsTriedAtOnceAndThenEverLessOften) {
  BackOff back_off;
  EXPECT_EQ(tries(back_off, 64), (std::vector<int>{0, 1, 3, 7, 15, 31, 47, 63}));
}

TEST(BackOff, AfterSuccessTheNextNeedIsTriedAtOnce) {
  BackOff back_off;
  tries(back_off, 40);
  back_off.reset();
  EXPECT_EQ(tries(back_off, 4), (std::vector<int>{0, 1, 3}));
}

}  // namespace
}  // namespace ovws
