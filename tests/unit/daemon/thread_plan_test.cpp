/// ThreadPlan: threads that hang, fail or do not end, with agents that the test controls.
#include "daemon/ovwsd/threads/thread_plan.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <semaphore>
#include <stdexcept>

#include "tests/support/time.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

/// An agent whose second turn lasts until the test releases it.
class Sticky : public Agent {
 public:
  bool do_work() override {
    if (++turns == 2) go_.acquire();
    std::this_thread::sleep_for(1ms);
    return true;
  }
  void on_close() override { closed = true; }
  void let_go() { go_.release(); }

  std::atomic<int> turns{0};
  std::atomic<bool> closed{false};

 private:
  std::counting_semaphore<> go_{0};
};

void wait_for(const std::function<bool()>& condition) {
  for (int tries = 0; tries < 5000 && !condition(); ++tries) std::this_thread::sleep_for(2ms);
  ASSERT_TRUE(condition());
}

/// Lets the longest turn of ThreadRole::track pass.
void skip_longest_turn() {
  const auto track = std::find_if(kThreadTable.begin(), kThreadTable.end(),
                                  [](const auto& row) { return row.role == ThreadRole::track; });
  test::skip(std::chrono::nanoseconds(std::int64_t(1e9 * track->longest_turn_s)) + 1ms);
}

std::string names(const std::vector<HungThread>& hung) {
  std::string text;
  for (const HungThread& one : hung) text += std::string(one.row->name) + " ";
  return text;
}

TEST(ThreadPlan, ATurnThatTakesTooLongIsNamedUntilItEnds) {
  Sticky agent;
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::track, agent));  // has the shortest longest_turn_s
  wait_for([&] { return agent.turns == 2; });
  test::skip(-1h);  // the turn is not too long, however busy the machine is
  EXPECT_EQ(names(plan.hung_threads()), "");
  test::skip(1h);
  skip_longest_turn();
  EXPECT_EQ(names(plan.hung_threads()), "track ");
  agent.let_go();
  wait_for([&] { return plan.hung_threads().empty(); });
}

TEST(ThreadPlan, AThreadThatHasEndedDoesNotHang) {
  Sticky agent;
  agent.let_go();
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::track, agent));
  plan.end_soon({ThreadRole::track});
  wait_for([&] { return agent.closed.load(); });
  skip_longest_turn();
  wait_for([&] { return plan.hung_threads().empty(); });
}

TEST(ThreadPlan, AThreadThatDoesNotEndIsNamedAndTheOthersAreStopped) {
  Sticky agent;
  Sticky other;
  other.let_go();
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::publish, other));
  ASSERT_TRUE(plan.start(ThreadRole::camera, agent));
  wait_for([&] { return agent.turns == 2; });
  plan.end_soon({ThreadRole::publish});
  wait_for([&] { return other.closed.load(); });
  EXPECT_EQ(plan.stop_all(0.05), "camera");
  EXPECT_FALSE(agent.closed);
  agent.let_go();
}

/// An agent whose first turn throws.
class Failing : public Agent {
 public:
  bool do_work() override {
    if (++turns == 1) throw std::runtime_error("bad bug");
    std::this_thread::sleep_for(1ms);
    return true;
  }
  void on_close() override { closed = true; }

  std::atomic<int> turns{0};
  std::atomic<bool> closed{false};
};

/// Collects the failures that a plan reports.
class Failures {
 public:
  OnThreadFailure sink() {
    return [this](const ThreadFailure& failure) {
      const std::lock_guard lock(mutex_);
      text_ += std::string(failure.row->name) + ": " + failure.what + "; ";
    };
  }
  std::string text() {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  std::mutex mutex_;
  std::string text_;
};

TEST(ThreadPlan, AnExceptionIsReportedAndTheThreadGoesOn) {
  Failing agent;
  Failures failures;
  ThreadPlan plan(RealtimePolicy::ignore, {}, failures.sink());
  ASSERT_TRUE(plan.start(ThreadRole::loop, agent));
  wait_for([&] { return agent.turns > 2; });
  EXPECT_EQ(failures.text(), "loop: bad bug; ");
  EXPECT_EQ(plan.fatal_failure(), "");
  EXPECT_EQ(plan.stop_all(5.0), "");
  EXPECT_TRUE(agent.closed);
}

TEST(ThreadPlan, AnExceptionOnTheFramePathEndsTheProcessInOrder) {
  Failing agent;
  Sticky shown;
  shown.let_go();
  Failures failures;
  ThreadPlan plan(RealtimePolicy::ignore, {}, failures.sink());
  ASSERT_TRUE(plan.start(ThreadRole::acquire, agent));
  const std::atomic<bool> never{false};
  plan.run_here(ThreadRole::display, shown, never);
  EXPECT_EQ(plan.fatal_failure(), "thread acquire failed: bad bug");
  EXPECT_EQ(failures.text(), "acquire: bad bug; ");
  EXPECT_EQ(plan.stop_all(5.0), "");
  EXPECT_EQ(agent.turns, 1);
}

TEST(ThreadPlan, AnExceptionInTheCallersOwnTurnsEndsThem) {
  Failing agent;
  ThreadPlan plan(RealtimePolicy::ignore);
  const std::atomic<bool> never{false};
  plan.run_here(ThreadRole::display, agent, never);
  EXPECT_EQ(plan.fatal_failure(), "thread main failed: bad bug");
  EXPECT_EQ(agent.turns, 1);
}

/// Otherwise the threads' times to end would add up.
TEST(ThreadPlan, AllAreAskedToEndBeforeAnyIsWaitedFor) {
  class Ending : public Agent {
   public:
    bool do_work() override {
      std::this_thread::sleep_for(1ms);
      return true;
    }
    void on_close() override {
      closed = true;
      for (int tries = 0; tries < 2500 && other != nullptr && !other->closed; ++tries) {
        std::this_thread::sleep_for(2ms);
      }
      together = other == nullptr || other->closed;
    }
    const Ending* other = nullptr;
    std::atomic<bool> closed{false}, together{false};
  };
  Ending first, last;
  last.other = &first;
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::publish, first));
  ASSERT_TRUE(plan.start(ThreadRole::camera, last));
  EXPECT_EQ(plan.stop_all(10.0), "");
  EXPECT_TRUE(last.together);
}

TEST(ThreadPlan, SomeEndBeforeTheOthers) {
  Sticky write, status;
  write.let_go();
  status.let_go();
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::status, status));
  ASSERT_TRUE(plan.start(ThreadRole::write, write));
  plan.end_soon({ThreadRole::write});
  EXPECT_EQ(plan.wait_for_end({ThreadRole::write}, 10.0), "");
  EXPECT_TRUE(write.closed);
  const int turns = status.turns;
  wait_for([&] { return status.turns > turns + 2; });
  EXPECT_FALSE(status.closed);
}

TEST(ThreadPlan, ThreadsOfLongComputationsRunAtALowerPriority) {
  class Asking : public Agent {
   public:
    bool do_work() override {
      nice = getpriority(PRIO_PROCESS, 0);
      return true;
    }
    std::atomic<int> nice{-1};
  };
  const int ours = getpriority(PRIO_PROCESS, 0);
  Asking refining, other;
  ThreadPlan plan(RealtimePolicy::ignore);
  ASSERT_TRUE(plan.start(ThreadRole::refine, refining));
  ASSERT_TRUE(plan.start(ThreadRole::status, other));
  wait_for([&] { return refining.nice == std::max(15, ours) && other.nice == ours; });
}

class Where : public Agent {
 public:
  bool do_work() override {
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof(set), &set);
    count = CPU_COUNT(&set);
    first = 0;
    while (first < CPU_SETSIZE - 1 && !CPU_ISSET(std::size_t(first.load()), &set)) ++first;
    std::this_thread::sleep_for(1ms);
    return true;
  }
  std::atomic<int> count{0};
  std::atomic<int> first{0};
};

TEST(ThreadPlan, OnlyTheFramePathIsBoundToTheConfiguredCpus) {
  cpu_set_t ours;
  CPU_ZERO(&ours);
  ASSERT_EQ(sched_getaffinity(0, sizeof(ours), &ours), 0);
  int last = CPU_SETSIZE - 1;
  while (!CPU_ISSET(std::size_t(last), &ours)) --last;
  Where path, other;
  ThreadPlan plan(RealtimePolicy::ignore, {last});
  ASSERT_TRUE(check_cpus({last}));
  ASSERT_TRUE(plan.start(ThreadRole::acquire, path));
  ASSERT_TRUE(plan.start(ThreadRole::status, other));
  wait_for([&] { return path.count == 1 && path.first == last; });
  wait_for([&] { return other.count == CPU_COUNT(&ours); });
}

TEST(ThreadPlan, AMissingCpuIsRefusedWithTheListOfUsableOnes) {
  EXPECT_TRUE(check_cpus({}));
  cpu_set_t ours;
  CPU_ZERO(&ours);
  ASSERT_EQ(sched_getaffinity(0, sizeof(ours), &ours), 0);
  int missing = 0;
  while (CPU_ISSET(std::size_t(missing), &ours)) ++missing;
  const auto there = check_cpus({missing});
  ASSERT_FALSE(there);
  EXPECT_EQ(there.error().field, "pipeline.cpus");
  EXPECT_NE(there.error().reason.find("processor " + std::to_string(missing) + ": choose from"),
            std::string::npos)
      << there.error().reason;
}

TEST(ThreadPlan, TheCallersOwnTurnsAreWatchedAndAnOverdueStopIsSeen) {
  Sticky agent;
  std::atomic<bool> stop{false};
  ThreadPlan plan(RealtimePolicy::ignore);
  std::thread caller([&] { plan.run_here(ThreadRole::display, agent, stop); });
  wait_for([&] { return agent.turns == 2; });
  EXPECT_FALSE(plan.stop_overdue(0.0));
  stop = true;
  wait_for([&] {
    test::skip(10ms);
    return plan.stop_overdue(0.1);
  });
  agent.let_go();
  caller.join();
  EXPECT_FALSE(plan.stop_overdue(0.0));
}

}  // namespace
}  // namespace ovws
