#include "core/rt/priority_mutex.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

namespace ovws {
namespace {

/// Priority at which the kernel runs the thread (`priority` of proc(5)): -1 - N for SCHED_FIFO N.
int kernel_priority(pid_t thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string field;
  for (int k = 3; k <= 18; ++k) fields >> field;
  return std::stoi(field);
}

TEST(PriorityMutex, AThreadThatHoldsItRunsAtThePriorityOfTheOneThatWaits) {
  constexpr int kFifo = 10;
  PriorityMutex mutex;
  std::unique_lock<std::mutex> held(mutex);
  const pid_t holder = gettid();
  const int before = kernel_priority(holder);
  std::atomic<int> refused{-1};
  std::thread urgent([&] {
    const sched_param at{kFifo};
    refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &at);
    const std::lock_guard lock(mutex);
  });
  while (refused == -1) std::this_thread::yield();
  int raised = before;
  for (int wait = 0; refused == 0 && wait < 2000 && raised == before; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    raised = kernel_priority(holder);
  }
  held.unlock();
  urgent.join();
  if (refused != 0) GTEST_SKIP() << "this user may not use SCHED_FIFO";
  EXPECT_EQ(raised, -1 - kFifo);
  EXPECT_EQ(kernel_priority(holder), before);
}

TEST(PriorityMutex, ServesAConditionVariable) {
  PriorityMutex mutex;
  std::condition_variable changed;
  bool ready = false;
  std::thread other([&] {
    const std::lock_guard lock(mutex);
    ready = true;
    changed.notify_one();
  });
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait(lock, [&] { return ready; });
  lock.unlock();
  other.join();
  EXPECT_TRUE(ready);
}

}  // namespace
}  // namespace ovws
