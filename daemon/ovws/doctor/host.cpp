#include "daemon/ovws/doctor/host.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <array>

#include "daemon/ovwsd/threads/thread_plan.hpp"

namespace ovws::doctor {
namespace {

/// A missing privilege is a fault if `realtime` is `enforce` (the daemon does not start), else a
/// warning (frames are late).
Finding missing(const HostFacts& facts, std::string name, std::string meaning, std::string fix) {
  if (facts.policy == RealtimePolicy::enforce) {
    return fault(std::move(name), meaning + ", and \"realtime\" is \"enforce\": no start",
                 std::move(fix));
  }
  return warning(std::move(name), std::move(meaning), std::move(fix));
}

std::string whose(const HostFacts& facts) {
  return facts.of_service ? "the service" : "a daemon that this user starts";
}

std::string limits_fix(const HostFacts& facts, const char* item, const char* value) {
  if (facts.of_service) return "sudo systemctl revert ovwsd && sudo systemctl restart ovwsd";
  return fmt::format(
      "sudo systemctl start ovwsd, or: echo \"$USER - {} {}\" | sudo tee -a "
      "/etc/security/limits.d/ovws.conf, and log in again",
      item, value);
}

Finding judge_priority(const HostFacts& facts) {
  constexpr const char* kName = "realtime.priority";
  if (!facts.limits) return not_here(kName, "the system does not tell a process's limits");
  const int needed = std::ranges::max(kThreadTable, {}, &ThreadRow::fifo_priority).fifo_priority;
  const Limits& limits = *facts.limits;
  if (limits.may_any_priority || limits.realtime_priority >= std::uint64_t(needed)) {
    return ok(kName, whose(facts) + " gets the priorities of the frame path");
  }
  return missing(facts, kName,
                 fmt::format("{} may have priorities up to {}, the frame path wants {}: other "
                             "programs delay frames",
                             whose(facts), limits.realtime_priority, needed),
                 limits_fix(facts, "rtprio", "90"));
}

Finding judge_memory(const HostFacts& facts) {
  constexpr const char* kName = "realtime.memory";
  if (!facts.limits) return not_here(kName, "the system does not tell a process's limits");
  if (facts.limits->may_lock_all || !facts.limits->locked_bytes) {
    return ok(kName, whose(facts) + " may lock all of its memory");
  }
  return missing(facts, kName,
                 fmt::format("{} may lock {} MiB of memory and not all: page faults delay frames",
                             whose(facts), *facts.limits->locked_bytes >> 20),
                 limits_fix(facts, "memlock", "unlimited"));
}

Finding judge_throttling(const HostFacts& facts) {
  constexpr const char* kName = "realtime.throttling";
  constexpr double kEnough = 0.9;  // the kernel's own default is 0.95
  constexpr const char* kFix = "sudo sysctl -w kernel.sched_rt_runtime_us=950000";
  if (!facts.rt_runtime_us || !facts.rt_period_us || *facts.rt_period_us <= 0) {
    return not_here(kName, "kernel.sched_rt_runtime_us is not to be seen here");
  }
  if (*facts.rt_runtime_us < 0) return ok(kName, "the kernel never holds real-time threads");
  const double share = double(*facts.rt_runtime_us) / double(*facts.rt_period_us);
  const std::string says =
      fmt::format("real-time threads may use {:.0f} % of a processor", 100.0 * share);
  if (share >= kEnough) return ok(kName, says);
  return missing(facts, kName, says + ": beyond that they are held and frames are late", kFix);
}

Finding judge_governor(const HostFacts& facts) {
  constexpr const char* kName = "cpu.governor";
  if (facts.governors.empty()) return not_here(kName, "nothing here sets the processors' clock");
  const std::string names = fmt::format("{}", fmt::join(facts.governors, ", "));
  if (facts.governors == std::vector<std::string>{"performance"}) {
    return ok(kName, "all processors run at their full clock");
  }
  return warning(
      kName,
      "the processors' governor is " + names +
          ": they slow down between frames, which then are late",
      "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

Finding judge_sleep(const HostFacts& facts) {
  constexpr const char* kName = "cpu.sleep";
  constexpr const char* kPath = "/dev/cpu_dma_latency";
  if (facts.dma_latency == Access::absent) {
    return not_here(kName, std::string("there is no ") + kPath);
  }
  if (facts.dma_latency == Access::given) {
    return ok(kName, std::string(kPath) + " can be written: a daemon keeps the processor awake");
  }
  const std::string meaning =
      std::string(kPath) + " cannot be written by this user: the processor's sleep delays frames";
  if (facts.of_service) {
    return not_here(kName, meaning + " of a daemon that it starts; the service has its own group");
  }
  return missing(facts, kName, meaning + " of a daemon that it starts; the service may write it",
                 "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=misc && "
                 "sudo systemctl start ovwsd");
}

Finding judge_clock_source(const HostFacts& facts) {
  constexpr const char* kName = "clock.source";
  // Clock sources that the vDSO reads without a system call.
  constexpr std::array<std::string_view, 4> kQuick{"tsc", "kvm-clock", "arch_sys_counter",
                                                   "hyperv_clocksource_tsc_page"};
  if (!facts.clock_source) return not_here(kName, "the kernel does not tell its clock source");
  if (std::ranges::find(kQuick, *facts.clock_source) != kQuick.end()) {
    return ok(kName, "times come from " + *facts.clock_source);
  }
  return warning(
      kName,
      "times come from " + *facts.clock_source +
          ", which takes a microsecond or more to read; if the kernel's log calls tsc unstable, "
          "the firmware needs an update",
      "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource");
}

Finding judge_synchronised(const HostFacts& facts) {
  constexpr const char* kName = "clock.synchronised";
  if (!facts.clock_synchronised) return not_here(kName, "the kernel does not tell of its clock");
  if (*facts.clock_synchronised) return ok(kName, "the clock follows a time server");
  return warning(kName,
                 "the clock follows no time server: times in messages cannot be compared with "
                 "those of other machines",
                 "sudo timedatectl set-ntp true");
}

}  // namespace

Findings judge(const HostFacts& facts) {
  return {judge_priority(facts),    judge_memory(facts), judge_throttling(facts),
          judge_governor(facts),    judge_sleep(facts),  judge_clock_source(facts),
          judge_synchronised(facts)};
}

}  // namespace ovws::doctor
