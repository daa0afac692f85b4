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
    return fault(std::move(name),
                 meaning + "; the daemon does not start, because \"realtime\" is \"enforce\"",
                 std::move(fix));
  }
  return warning(std::move(name), std::move(meaning), std::move(fix));
}

std::string daemon_name(const HostFacts& facts) {
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
  if (!facts.limits) return not_here(kName, "the system does not report a process's limits");
  const int needed = std::ranges::max(kThreadTable, {}, &ThreadRow::fifo_priority).fifo_priority;
  const Limits& limits = *facts.limits;
  if (limits.may_any_priority || limits.realtime_priority >= std::uint64_t(needed)) {
    return ok(kName, daemon_name(facts) + " may use the real-time priorities of the frame path");
  }
  return missing(facts, kName,
                 fmt::format("{} may use real-time priorities up to {}, the frame path needs {}: "
                             "other programs delay frames",
                             daemon_name(facts), limits.realtime_priority, needed),
                 limits_fix(facts, "rtprio", "90"));
}

Finding judge_memory(const HostFacts& facts) {
  constexpr const char* kName = "realtime.memory";
  if (!facts.limits) return not_here(kName, "the system does not report a process's limits");
  if (facts.limits->may_lock_all || !facts.limits->locked_bytes) {
    return ok(kName, daemon_name(facts) + " may lock all its memory");
  }
  return missing(facts, kName,
                 fmt::format("{} may lock only {} MiB of memory: page faults delay frames",
                             daemon_name(facts), *facts.limits->locked_bytes >> 20),
                 limits_fix(facts, "memlock", "unlimited"));
}

Finding judge_throttling(const HostFacts& facts) {
  constexpr const char* kName = "realtime.throttling";
  constexpr double kMinShare = 0.9;  // the kernel's own default is 0.95
  constexpr const char* kFix = "sudo sysctl -w kernel.sched_rt_runtime_us=950000";
  if (!facts.rt_runtime_us || !facts.rt_period_us || *facts.rt_period_us <= 0) {
    return not_here(kName, "kernel.sched_rt_runtime_us cannot be read here");
  }
  if (*facts.rt_runtime_us < 0) return ok(kName, "the kernel does not throttle real-time threads");
  const double share = double(*facts.rt_runtime_us) / double(*facts.rt_period_us);
  const std::string says =
      fmt::format("real-time threads may use {:.0f} % of a CPU", 100.0 * share);
  if (share >= kMinShare) return ok(kName, says);
  return missing(facts, kName, says + ": above that the kernel throttles them and frames are late",
                 kFix);
}

Finding judge_governor(const HostFacts& facts) {
  constexpr const char* kName = "cpu.governor";
  if (facts.governors.empty()) return not_here(kName, "there is no CPU frequency scaling here");
  const std::string names = fmt::format("{}", fmt::join(facts.governors, ", "));
  if (facts.governors == std::vector<std::string>{"performance"}) {
    return ok(kName, "all CPUs use the performance governor");
  }
  return warning(
      kName,
      "the CPU frequency governor is " + names +
          ": CPUs slow down between frames and make them late",
      "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

Finding judge_sleep(const HostFacts& facts) {
  constexpr const char* kName = "cpu.sleep";
  constexpr const char* kPath = "/dev/cpu_dma_latency";
  if (facts.dma_latency == Access::absent) {
    return not_here(kName, std::string(kPath) + " does not exist");
  }
  if (facts.dma_latency == Access::given) {
    return ok(kName, std::string(kPath) + " is writable: a daemon can prevent deep CPU sleep");
  }
  const std::string meaning =
      std::string(kPath) + " is not writable for this user: CPU sleep states delay the frames";
  if (facts.of_service) {
    return not_here(
        kName, meaning + " of a daemon that it starts; the service has access through its group");
  }
  return missing(facts, kName, meaning + " of a daemon that it starts; the service has access",
                 "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=misc && "
                 "sudo systemctl start ovwsd");
}

Finding judge_clock_source(const HostFacts& facts) {
  constexpr const char* kName = "clock.source";
  // Clock sources that the vDSO reads without a system call.
  constexpr std::array<std::string_view, 4> kVdsoSources{"tsc", "kvm-clock", "arch_sys_counter",
                                                         "hyperv_clocksource_tsc_page"};
  if (!facts.clock_source) return not_here(kName, "the kernel does not report its clock source");
  if (std::ranges::find(kVdsoSources, *facts.clock_source) != kVdsoSources.end()) {
    return ok(kName, "the clock source is " + *facts.clock_source);
  }
  return warning(
      kName,
      "the clock source is " + *facts.clock_source +
          ", which takes a microsecond or more to read; if the kernel log says that tsc is "
          "unstable, update the firmware",
      "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource");
}

Finding judge_synchronised(const HostFacts& facts) {
  constexpr const char* kName = "clock.synchronised";
  if (!facts.clock_synchronised)
    return not_here(kName, "the kernel does not report whether its clock is synchronised");
  if (*facts.clock_synchronised) return ok(kName, "the clock is synchronised to a time server");
  return warning(kName,
                 "the clock is not synchronised to a time server: times in messages cannot be "
                 "compared with those of other machines",
                 "sudo timedatectl set-ntp true");
}

}  // namespace

Findings judge(const HostFacts& facts) {
  return {judge_priority(facts),    judge_memory(facts), judge_throttling(facts),
          judge_governor(facts),    judge_sleep(facts),  judge_clock_source(facts),
          judge_synchronised(facts)};
}

}  // namespace ovws::doctor
