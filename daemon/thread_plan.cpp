#include "daemon/thread_plan.hpp"

#include <pthread.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <future>

#include "core/port/clock.hpp"

namespace ovws {

struct ThreadPlan::Running {
  const ThreadRow* row = nullptr;
  Agent* agent = nullptr;
  std::atomic<bool> stop{false};
  std::atomic<std::int64_t> turn_began_ns{0};
  std::promise<void> ended;
  std::thread thread;
};

namespace {

const ThreadRow& row_of(ThreadRole role) {
  return *std::find_if(kThreadTable.begin(), kThreadTable.end(),
                       [role](const ThreadRow& row) { return row.role == role; });
}

int set_fifo(std::thread& thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &parameters);
}

}  // namespace

ThreadPlan::ThreadPlan(RealtimePolicy policy) : policy_(policy) {}

ThreadPlan::~ThreadPlan() {
  constexpr double kOneDayS = 86400.0;
  stop_all(kOneDayS);
}

Result<void> ThreadPlan::prepare_process() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  const std::string why = std::strerror(errno);
  if (policy_ == RealtimePolicy::enforce) {
    return fail(Errc::unavailable, "realtime",
                "memory cannot be locked (" + why +
                    "): raise LimitMEMLOCK, or set \"realtime\": \"ignore\"");
  }
  spdlog::warn("memory is not locked ({}): page faults may delay frames", why);
  return {};
}

Result<void> ThreadPlan::start(ThreadRole role, Agent& agent) {
  auto made = std::make_unique<Running>();
  Running& running = *made;
  running.row = &row_of(role);
  running.agent = &agent;
  running.turn_began_ns = monotonic_ns();
  {
    const std::lock_guard lock(mutex_);
    threads_.push_back(std::move(made));
  }
  running.thread = std::thread([this, &running] { run(running); });
  pthread_setname_np(running.thread.native_handle(), running.row->name);
  if (running.row->fifo_priority == 0) return {};
  const int status = set_fifo(running.thread, running.row->fifo_priority);
  if (status == 0) return {};
  if (policy_ == RealtimePolicy::enforce) {
    return fail(Errc::unavailable, "realtime",
                std::string("thread ") + running.row->name + " cannot get SCHED_FIFO (" +
                    std::strerror(status) +
                    "): raise LimitRTPRIO, or set \"realtime\": \"ignore\"");
  }
  spdlog::warn("thread {} runs without SCHED_FIFO ({})", running.row->name, std::strerror(status));
  return {};
}

void ThreadPlan::run(Running& running) {
  while (!running.stop.load(std::memory_order_relaxed)) {
    running.turn_began_ns.store(monotonic_ns(), std::memory_order_relaxed);
    running.agent->do_work();
  }
  running.agent->on_close();
  running.ended.set_value();
}

std::string ThreadPlan::stop_all(double patience_s) {
  constexpr std::chrono::milliseconds kLeast(200);  // even behind one that is held
  std::string held;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  for (auto running = threads_.rbegin(); running != threads_.rend(); ++running) {
    Running& one = **running;
    one.stop = true;
    if (!one.thread.joinable()) continue;
    auto ended = one.ended.get_future();
    if (ended.wait_until(until) == std::future_status::ready ||
        ended.wait_for(kLeast) == std::future_status::ready) {
      one.thread.join();
    } else if (held.empty()) {
      held = one.row->name;
    }
  }
  return held;
}

std::string ThreadPlan::hung_thread() const {
  const std::lock_guard lock(mutex_);
  const std::int64_t now_ns = monotonic_ns();
  for (const auto& running : threads_) {
    const double turn_s = 1e-9 * double(now_ns - running->turn_began_ns.load());
    if (turn_s > running->row->longest_turn_s) return running->row->name;
  }
  return {};
}

}  // namespace ovws
