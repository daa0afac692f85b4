#include "daemon/ovwsd/threads/thread_plan.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <spdlog/fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <future>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {

struct ThreadPlan::Running {
  const ThreadRow* row = nullptr;
  Agent* agent = nullptr;
  std::atomic<bool> stop{false};
  std::atomic<std::int64_t> turn_began_ns{0};
  std::promise<void> ending;
  std::future<void> ended = ending.get_future();
  std::thread thread;
};

namespace {

const std::vector<ThreadRole> kEveryRole = [] {
  std::vector<ThreadRole> roles;
  for (const ThreadRow& row : kThreadTable) roles.push_back(row.role);
  return roles;
}();
constexpr const char* kDmaLatency = "/dev/cpu_dma_latency";

const ThreadRow& row_of(ThreadRole role) {
  return *std::find_if(kThreadTable.begin(), kThreadTable.end(),
                       [role](const ThreadRow& row) { return row.role == role; });
}

bool contains(const std::vector<ThreadRole>& roles, ThreadRole role) {
  return std::find(roles.begin(), roles.end(), role) != roles.end();
}

int set_fifo(std::thread& thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &parameters);
}

cpu_set_t set_of(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(std::size_t(cpu), &set);
  return set;
}

}  // namespace

Result<void> check_cpus(const std::vector<int>& cpus) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  // sched_getaffinity fails if the host has more processors than a cpu_set_t holds. Pinning then
  // reports the error when the threads start.
  if (cpus.empty() || sched_getaffinity(0, sizeof(allowed), &allowed) != 0) return {};
  std::vector<int> usable;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(std::size_t(cpu), &allowed)) usable.push_back(cpu);
  }
  for (const int cpu : cpus) {
    if (cpu >= 0 && cpu < CPU_SETSIZE && CPU_ISSET(std::size_t(cpu), &allowed)) continue;
    return fail(Errc::invalid, "pipeline.cpus",
                fmt::format("this process may not run on processor {}: choose from {}", cpu,
                            fmt::join(usable, ", ")));
  }
  return {};
}

void keep_stacks_small() {
  constexpr std::size_t kStackBytes = 1 << 20;
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

ThreadPlan::ThreadPlan(RealtimePolicy policy, std::vector<int> frame_path_cpus,
                       OnThreadFailure on_failure)
    : policy_(policy),
      frame_path_cpus_(std::move(frame_path_cpus)),
      on_failure_(std::move(on_failure)),
      here_(std::make_unique<Running>()) {}

ThreadPlan::~ThreadPlan() {
  constexpr double kOneDayS = 86400.0;
  stop_all(kOneDayS);
  if (dma_latency_fd_ >= 0) ::close(dma_latency_fd_);
}

Result<void> ThreadPlan::prepare_process() {
  if (auto locked = lock_memory(); !locked) return locked;
  return keep_processor_awake();
}

Result<void> ThreadPlan::lock_memory() const {
  // Lock later mappings only when first used (MCL_ONFAULT): the display driver maps much memory,
  // and most of it is never used.
  if (mlockall(MCL_CURRENT) == 0 && mlockall(MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  const std::string why = std::strerror(errno);
  if (policy_ == RealtimePolicy::enforce) {
    return fail(
        Errc::unavailable, "realtime",
        "memory cannot be locked (" + why +
            "): run \"ulimit -l unlimited\" first in a shell, or set LimitMEMLOCK=infinity in "
            "the service's unit; or, if delays may happen, set \"realtime\": \"ignore\"");
  }
  spdlog::warn("memory is not locked ({}): page faults may delay frames", why);
  return {};
}

Result<void> ThreadPlan::keep_processor_awake() {
  constexpr std::int32_t kNoLatencyUs = 0;
  dma_latency_fd_ = ::open(kDmaLatency, O_WRONLY | O_CLOEXEC);
  if (dma_latency_fd_ >= 0 &&
      ::write(dma_latency_fd_, &kNoLatencyUs, sizeof(kNoLatencyUs)) == sizeof(kNoLatencyUs)) {
    return {};
  }
  const std::string why = std::strerror(errno);
  if (policy_ == RealtimePolicy::enforce) {
    return fail(Errc::unavailable, "realtime",
                std::string(kDmaLatency) + " cannot be written (" + why +
                    "): give the daemon's group write access (70-ovws-camera.rules), or set "
                    "\"realtime\": \"ignore\"");
  }
  spdlog::warn(
      "{} cannot be written ({}): idle states of the processor may delay frames; start "
      "ovwsd as its service, or give its user write access",
      kDmaLatency, why);
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
  if (auto pinned = pin(running); !pinned) return pinned;
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

Result<void> ThreadPlan::pin(Running& running) const {
  if (frame_path_cpus_.empty()) return {};
  const cpu_set_t set = set_of(frame_path_cpus_);
  const int status = pthread_setaffinity_np(running.thread.native_handle(), sizeof(set), &set);
  if (status != 0) {
    return fail(Errc::invalid, "pipeline.cpus",
                fmt::format("thread {} cannot be pinned to processors {}: {}", running.row->name,
                            fmt::join(frame_path_cpus_, ", "), std::strerror(status)));
  }
  spdlog::info("thread {} is pinned to processors {}", running.row->name,
               fmt::join(frame_path_cpus_, ", "));
  return {};
}

void ThreadPlan::run(Running& running) {
  // On Linux each thread has its own nice value, and a thread may always raise it. Keep the value
  // if the whole process already runs at a higher one.
  const int ours = getpriority(PRIO_PROCESS, 0);
  if (running.row->nice > ours) setpriority(PRIO_PROCESS, id_t(gettid()), running.row->nice);
  bool whole = true;
  while (whole && !running.stop.load(std::memory_order_relaxed)) {
    running.turn_began_ns.store(monotonic_ns(), std::memory_order_relaxed);
    if (guarded(*running.row, [&running] { running.agent->do_work(); })) continue;
    whole = running.row->on_exception == OnException::go_on;
    if (whole) pause(running);
  }
  if (whole) guarded(*running.row, [&running] { running.agent->on_close(); });
  running.ending.set_value();
}

/// Runs `work`. If an exception leaves `work`, reports the exception and returns false.
bool ThreadPlan::guarded(const ThreadRow& row, const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const std::exception& error) {
    report(row, error.what());
  } catch (...) {
    report(row, "an exception of unknown type");
  }
  return false;
}

/// Waits a second after a failed turn. A turn that always fails is thus reported once a second and
/// uses no processor time.
void ThreadPlan::pause(const Running& running) {
  constexpr std::int64_t kPauseNs = 1'000'000'000;
  constexpr std::chrono::milliseconds kStep(20);
  const std::int64_t until_ns = monotonic_ns() + kPauseNs;
  while (!running.stop && monotonic_ns() < until_ns) std::this_thread::sleep_for(kStep);
}

void ThreadPlan::report(const ThreadRow& row, const std::string& what) {
  const bool is_fatal = row.on_exception == OnException::restart;
  try {
    if (is_fatal) {
      const std::lock_guard lock(mutex_);
      if (fatal_failure_.empty()) {
        fatal_failure_ = fmt::format("thread {} failed: {}", row.name, what);
      }
    }
    if (on_failure_) {
      on_failure_({&row, what});
    } else {
      spdlog::error("thread {} failed: {}", row.name, what);
    }
  } catch (const std::exception&) {  // no memory for the text: decide without it
  }
  if (is_fatal) has_fatal_failure_ = true;  // set last: the main thread then reads the text, ends
}

std::string ThreadPlan::fatal_failure() const {
  const std::lock_guard lock(mutex_);
  return has_fatal_failure_ && fatal_failure_.empty() ? "a thread failed" : fatal_failure_;
}

void ThreadPlan::run_here(ThreadRole role, Agent& agent, const std::atomic<bool>& stop) {
  Running& here = *here_;
  here.turn_began_ns = monotonic_ns();
  {
    const std::lock_guard lock(mutex_);
    here.row = &row_of(role);
    stop_here_ = &stop;
  }
  while (!stop.load(std::memory_order_relaxed) && !has_fatal_failure_) {
    here.turn_began_ns.store(monotonic_ns(), std::memory_order_relaxed);
    guarded(*here.row, [&agent] { agent.do_work(); });
  }
  const std::lock_guard lock(mutex_);
  stop_here_ = nullptr;
}

void ThreadPlan::end_soon(const std::vector<ThreadRole>& roles) {
  const std::lock_guard lock(mutex_);
  for (const auto& running : threads_) {
    if (contains(roles, running->row->role)) running->stop = true;
  }
}

std::string ThreadPlan::wait_for_end(const std::vector<ThreadRole>& roles, double patience_s) {
  constexpr std::chrono::milliseconds kMinWait(200);  // per thread, once another one has not ended
  std::string held;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  for (auto running = threads_.rbegin(); running != threads_.rend(); ++running) {
    Running& one = **running;
    if (!contains(roles, one.row->role) || !one.thread.joinable()) continue;
    if (one.ended.wait_until(until) == std::future_status::ready ||
        (!held.empty() && one.ended.wait_for(kMinWait) == std::future_status::ready)) {
      one.thread.join();
    } else if (held.empty()) {
      held = one.row->name;
    }
  }
  return held;
}

std::string ThreadPlan::stop_all(double patience_s) {
  end_soon(kEveryRole);
  return wait_for_end(kEveryRole, patience_s);
}

std::vector<HungThread> ThreadPlan::hung_threads() const {
  std::vector<HungThread> hung;
  const std::lock_guard lock(mutex_);
  const std::int64_t now_ns = monotonic_ns();
  const auto look_at = [&](const Running& running) {
    const double turn_s = 1e-9 * double(now_ns - running.turn_began_ns.load());
    if (turn_s > running.row->longest_turn_s) hung.push_back({running.row, turn_s});
  };
  for (const auto& running : threads_) {
    const bool ended =
        running->ended.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (!ended) look_at(*running);
  }
  if (stop_here_ != nullptr) look_at(*here_);
  return hung;
}

bool ThreadPlan::stop_overdue(double patience_s) {
  const std::lock_guard lock(mutex_);
  if (stop_here_ == nullptr || !stop_here_->load()) return false;
  if (stop_seen_ns_ == 0) stop_seen_ns_ = monotonic_ns();
  return 1e-9 * double(monotonic_ns() - stop_seen_ns_) > patience_s;
}

}  // namespace ovws
