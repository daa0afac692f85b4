#include "daemon/thread_plan.hpp"

#include <pthread.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include "core/port/clock.hpp"

namespace ovws {

struct ThreadPlan::Running {
  const ThreadRow* row = nullptr;
  Agent* agent = nullptr;
  std::atomic<bool> stop{false};
  std::atomic<std::int64_t> turn_began_ns{0};
  std::thread thread;
};

namespace {

const ThreadRow& row_of(ThreadRole role) {
  return *std::find_if(kThreadTable.begin(), kThreadTable.end(),
                       [role](const ThreadRow& row) { return row.role == role; });
}

/// pthread_timedjoin_np counts by CLOCK_REALTIME.
timespec realtime_in(double seconds) {
  timespec time{};
  clock_gettime(CLOCK_REALTIME, &time);
  const double whole = std::floor(seconds);
  time.tv_sec += time_t(whole);
  time.tv_nsec += long(1e9 * (seconds - whole));
  if (time.tv_nsec >= 1'000'000'000) {
    time.tv_nsec -= 1'000'000'000;
    ++time.tv_sec;
  }
  return time;
}

int set_fifo(std::thread& thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &parameters);
}

}  // namespace

ThreadPlan::ThreadPlan(RealtimePolicy policy) : policy_(policy) {}

ThreadPlan::~ThreadPlan() {
  constexpr double kForEver = 1e6;
  stop_all(kForEver);
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
  threads_.push_back(std::make_unique<Running>());
  Running& running = *threads_.back();
  running.row = &row_of(role);
  running.agent = &agent;
  running.turn_began_ns = monotonic_ns();
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
}

std::string ThreadPlan::stop_all(double patience_s) {
  std::string held;
  const timespec until = realtime_in(patience_s);
  for (auto running = threads_.rbegin(); running != threads_.rend(); ++running) {
    Running& one = **running;
    one.stop = true;
    if (!one.thread.joinable()) continue;
    if (pthread_timedjoin_np(one.thread.native_handle(), nullptr, &until) == 0) {
      one.thread.detach();  // std::thread must not believe that there is still one to join
    } else {
      held = one.row->name;
    }
  }
  return held;
}

std::string ThreadPlan::hung_thread() const {
  const std::int64_t now_ns = monotonic_ns();
  for (const auto& running : threads_) {
    const double turn_s = 1e-9 * double(now_ns - running->turn_began_ns.load());
    if (turn_s > running->row->longest_turn_s) return running->row->name;
  }
  return {};
}

}  // namespace ovws
