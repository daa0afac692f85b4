// Wake-up latency of a real-time thread: what the machine itself adds to every latency.
//   ovws_wake_up CPU RATE_HZ SECONDS     as root; prints p50, p99 and p99.9 in microseconds
// The thread runs alone with SCHED_FIFO 90 and locked memory, and sleeps until absolute times.
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

constexpr int kPriority = 90;  // above every thread of ovwsd
constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;

bool become_real_time(int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  const sched_param parameters{.sched_priority = kPriority};
  return sched_setaffinity(0, sizeof cpus, &cpus) == 0 &&
         sched_setscheduler(0, SCHED_FIFO, &parameters) == 0 &&
         mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

// Sleeps until `deadline_ns` and returns by how much the thread woke up too late.
int64_t lateness_ns(int64_t deadline_ns) {
  const timespec deadline{.tv_sec = deadline_ns / kNanosecondsPerSecond,
                          .tv_nsec = deadline_ns % kNanosecondsPerSecond};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
  return now_ns() - deadline_ns;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4 || std::atof(arguments[2]) <= 0 || std::atof(arguments[3]) <= 0) {
    std::fprintf(stderr, "usage: ovws_wake_up CPU RATE_HZ SECONDS\n");
    return 2;
  }
  const double rate_hz = std::atof(arguments[2]);
  const auto period_ns = static_cast<int64_t>(1e9 / rate_hz);
  std::vector<int64_t> late(static_cast<size_t>(rate_hz * std::atof(arguments[3])) + 1);
  if (!become_real_time(std::atoi(arguments[1]))) {
    std::perror("SCHED_FIFO, the CPU or locked memory was refused; run as root");
    return 1;
  }
  int64_t deadline_ns = now_ns();
  for (int64_t& ns : late) ns = lateness_ns(deadline_ns += period_ns);
  std::sort(late.begin(), late.end());
  const auto at_us = [&](double share) {
    return 1e-3 * static_cast<double>(
                      late[static_cast<size_t>(share * static_cast<double>(late.size() - 1))]);
  };
  std::printf("%.0f %.0f %.0f\n", at_us(0.5), at_us(0.99), at_us(0.999));
}
