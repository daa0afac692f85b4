/// The ring keeps order, loses nothing, is full when it says, and never waits longer than asked.
#include "core/rt/spsc_ring.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

using std::chrono::microseconds;

TEST(SpscRing, KeepsOrder) {
  SpscRing<int> ring(8);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(ring.try_push(i));
  for (int i = 0; i < 5; ++i) {
    int item = -1;
    ASSERT_TRUE(ring.try_pop(item));
    EXPECT_EQ(item, i);
  }
  int none = -1;
  EXPECT_FALSE(ring.try_pop(none));
}

TEST(SpscRing, IsFullAtExactlyItsCapacity) {
  for (const std::size_t capacity : {1U, 2U, 3U, 5U, 8U}) {
    SpscRing<int> ring(capacity);
    for (std::size_t i = 0; i < capacity; ++i) EXPECT_TRUE(ring.try_push(int(i)));
    EXPECT_FALSE(ring.try_push(99));
    int item = -1;
    EXPECT_TRUE(ring.try_pop(item));
    EXPECT_EQ(item, 0);
    EXPECT_TRUE(ring.try_push(99));
  }
}

TEST(SpscRing, WaitingForNothingEndsAfterTheTimeOut) {
  SpscRing<int> ring(2);
  const std::int64_t begin = monotonic_ns();
  int item = -1;
  EXPECT_FALSE(ring.pop(item, microseconds(3000)));
  EXPECT_GE(monotonic_ns() - begin, 3'000'000);
}

TEST(SpscRing, APostLeftBehindDoesNotShortenTheWait) {
  SpscRing<int> ring(4);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(ring.try_push(i));
    int item = -1;
    ASSERT_TRUE(ring.try_pop(item));
  }
  const std::int64_t begin = monotonic_ns();
  int item = -1;
  EXPECT_FALSE(ring.pop(item, microseconds(2000)));
  EXPECT_GE(monotonic_ns() - begin, 2'000'000);
}

TEST(SpscRing, AWaitingThreadGetsWhatAnotherPushes) {
  SpscRing<int> ring(2);
  std::thread pusher([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_TRUE(ring.try_push(42));
  });
  int item = -1;
  EXPECT_TRUE(ring.pop(item, std::chrono::seconds(10)));
  EXPECT_EQ(item, 42);
  pusher.join();
}

TEST(SpscRing, UnderTwoThreadsNothingIsLostDoubledOrReordered) {
  struct Payload {
    int number = 0;
  };
  constexpr int kItems = 100000;
  std::vector<Payload> payloads(kItems);  // written by one thread, read by the other, no lock
  SpscRing<Payload*> ring(16);
  std::thread pusher([&] {
    for (int i = 0; i < kItems; ++i) {
      payloads[std::size_t(i)].number = i;
      while (!ring.try_push(&payloads[std::size_t(i)])) std::this_thread::yield();
    }
  });
  int wrong = 0;
  for (int i = 0; i < kItems; ++i) {
    Payload* item = nullptr;
    while (!ring.pop(item, microseconds(1000))) {
    }
    wrong += item->number != i ? 1 : 0;
  }
  pusher.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(ring.size_approx(), 0U);
}

}  // namespace
}  // namespace ovws
