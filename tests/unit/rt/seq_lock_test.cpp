#include "core/rt/seq_lock.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

namespace ovws {
namespace {

struct Facts {
  std::array<int, 15> all{};  // not a whole number of the lock's words
};

TEST(SeqLock, HasItsInitialValueUntilTheFirstWrite) {
  EXPECT_EQ(SeqLock<int>(7).read(), 7);
  EXPECT_EQ(SeqLock<Facts>().read().all, Facts{}.all);
}

TEST(SeqLock, AReaderNeverSeesPartsOfTwoValues) {
  SeqLock<Facts> lock;
  std::atomic<bool> written{false};
  std::thread writer([&] {
    Facts next;
    for (int k = 1; k <= 1'000'000; ++k) {
      next.all.fill(k);
      lock.write(next);
    }
    written = true;
  });
  int torn = 0, back = 0, newest = 0;
  while (!written) {
    const Facts seen = lock.read();
    for (const int one : seen.all) torn += one == seen.all[0] ? 0 : 1;
    back += seen.all[0] < newest ? 1 : 0;
    newest = seen.all[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(back, 0);
  EXPECT_EQ(lock.read().all[14], 1'000'000);
}

}  // namespace
}  // namespace ovws
