#include <gtest/gtest.h>

#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws {
namespace {

OperatorKey key_of(int subapertures_across) {
  OperatorKey key;
  key.sensor.subapertures_across = subapertures_across;
  return key;
}

TEST(OperatorShelfTest, AShortageOfMemoryIsForgottenWithAChangeAndARefusalIsNot) {
  OperatorShelf shelf;
  shelf.put(key_of(4), fail(Errc::unavailable, "tracking", "not enough memory"));
  shelf.put(key_of(5), fail(Errc::refused, "tracking", "the spots do not tell every mode"));
  shelf.put(key_of(6), ModeOperator{});
  const OperatorKey same = key_of(4), other = key_of(6);
  shelf.forget_shortages(&same);
  ASSERT_NE(shelf.find(same), nullptr);
  shelf.forget_shortages(&other);
  EXPECT_EQ(shelf.find(same), nullptr);
  ASSERT_NE(shelf.find(key_of(5)), nullptr);
  ASSERT_NE(shelf.find(other), nullptr);
  shelf.put(same, fail(Errc::unavailable, "tracking", "not enough memory"));
  shelf.forget_shortages(nullptr);
  EXPECT_EQ(shelf.find(same), nullptr);
}

}  // namespace
}  // namespace ovws
