/// The latest value: newest wins, never torn, never backwards, under two threads.
#include "core/rt/latest_value.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

namespace ovws {
namespace {

using Block = std::array<std::uint64_t, 32>;

TEST(LatestValue, BeforeTheFirstWriteTheReaderSeesTheInitialValue) {
  LatestValue<int> plain;
  EXPECT_FALSE(plain.update());
  EXPECT_EQ(plain.value(), 0);
  LatestValue<int> initial(7);
  EXPECT_FALSE(initial.update());
  EXPECT_EQ(initial.value(), 7);
}

TEST(LatestValue, OfSeveralWritesTheReaderSeesTheNewestOnce) {
  LatestValue<int> latest;
  for (int i = 1; i <= 5; ++i) latest.write(i);
  EXPECT_TRUE(latest.update());
  EXPECT_EQ(latest.value(), 5);
  EXPECT_FALSE(latest.update());
  EXPECT_EQ(latest.value(), 5);
}

TEST(LatestValue, UnderTwoThreadsValuesAreWholeAndNeverGoBack) {
  LatestValue<Block> latest;
  constexpr std::uint64_t kWrites = 200000;
  std::thread writer([&] {
    Block block{};
    for (std::uint64_t i = 1; i <= kWrites; ++i) {
      block.fill(i);
      latest.write(block);
    }
  });
  std::uint64_t seen = 0;
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  while (seen < kWrites) {
    if (!latest.update()) {
      std::this_thread::yield();
      continue;
    }
    const Block& block = latest.value();
    for (const std::uint64_t word : block) torn += word != block[0] ? 1 : 0;
    backwards += block[0] <= seen ? 1 : 0;
    seen = block[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
  EXPECT_FALSE(latest.update());
}

}  // namespace
}  // namespace ovws
