#include <gtest/gtest.h>

#include "daemon/ovwsd/sensor/mode_operators.hpp"

namespace ovws {
namespace {

OperatorKey key_of(int subapertures_across) {
  OperatorKey key;
  key.sensor.subapertures_across = subapertures_across;
  return key;
}

TEST(OperatorCacheTest, AShortageOfMemoryIsForgottenWithAChangeAndARefusalIsNot) {
  OperatorCache cache;
  cache.put(key_of(4), fail(Errc::unavailable, "tracking", "not enough memory"));
  cache.put(key_of(5), fail(Errc::refused, "tracking", "the spots do not tell every mode"));
  cache.put(key_of(6), ModeOperator{});
  const OperatorKey same = key_of(4), other = key_of(6);
  cache.forget_shortages(&same);
  ASSERT_NE(cache.find(same), nullptr);
  cache.forget_shortages(&other);
  EXPECT_EQ(cache.find(same), nullptr);
  ASSERT_NE(cache.find(key_of(5)), nullptr);
  ASSERT_NE(cache.find(other), nullptr);
  cache.put(same, fail(Errc::unavailable, "tracking", "not enough memory"));
  cache.forget_shortages(nullptr);
  EXPECT_EQ(cache.find(same), nullptr);
}

}  // namespace
}  // namespace ovws
