/// Counters: each has a name of its own, and none is lost between threads.
#include "core/rt/counters.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <thread>

namespace ovws {
namespace {

TEST(Counters, EveryCounterHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (std::size_t c = 0; c < std::size_t(Counter::count_); ++c) {
    const std::string_view name = counter_name(Counter(c));
    EXPECT_NE(name, "unknown");
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

TEST(Counters, CountFromSeveralThreadsWithoutLoss) {
  Counters counters;
  const auto count = [&] {
    for (int i = 0; i < 10000; ++i) counters.add(Counter::frames_grabbed);
    counters.add(Counter::spots_lost, 19);
  };
  std::thread one(count);
  std::thread other(count);
  one.join();
  other.join();
  EXPECT_EQ(counters.get(Counter::frames_grabbed), 20000U);
  EXPECT_EQ(counters.get(Counter::spots_lost), 38U);
  EXPECT_EQ(counters.get(Counter::frames_lost), 0U);
}

}  // namespace
}  // namespace ovws
