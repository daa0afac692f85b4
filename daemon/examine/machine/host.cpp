#include "daemon/examine/machine/machine.hpp"

#include <fcntl.h>
#include <sys/timex.h>
#include <unistd.h>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>
#include <algorithm>
#include <array>
#include <filesystem>

#include "core/base/number_text.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"

namespace ovws::examine {
namespace {

namespace fs = std::filesystem;

/// The first word after `label`, where `label` begins a line; empty if no line has it.
std::string_view word_behind(std::string_view text, std::string_view label) {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    if (!line.starts_with(label)) continue;
    line.remove_prefix(label.size());
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    return line.substr(0, line.find_first_of(" \t"));
  }
  return {};
}

/// The /proc folder of the daemon that systemd runs as ovwsd.service; none: it is not running.
std::optional<std::string> service_process() {
  std::error_code failed;
  for (const auto& one : fs::directory_iterator("/proc", failed)) {
    const std::string folder = one.path();
    if (word_of(folder + "/comm") != "ovwsd") continue;
    const auto group = text_of(folder + "/cgroup");
    if (group && group->find("/ovwsd.service") != std::string::npos) return folder;
  }
  return std::nullopt;
}

std::optional<Limits> limits_of(const std::string& process) {
  const auto limits = text_of(process + "/limits");
  const auto status = text_of(process + "/status");
  return limits && status ? parse_limits(*limits, *status) : std::nullopt;
}

std::vector<std::string> read_governors() {
  std::vector<std::string> names;
  std::error_code failed;
  for (const auto& cpu : fs::directory_iterator("/sys/devices/system/cpu", failed)) {
    const auto name = word_of(cpu.path() / "cpufreq" / "scaling_governor");
    if (name && std::ranges::find(names, *name) == names.end()) names.push_back(*name);
  }
  std::ranges::sort(names);
  return names;
}

Access read_dma_latency() {
  constexpr const char* kPath = "/dev/cpu_dma_latency";
  if (::access(kPath, F_OK) != 0) return Access::absent;
  // Open the device, because permissions alone do not decide access. Opening sets no latency limit;
  // only a write does.
  const int fd = ::open(kPath, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return Access::refused;
  ::close(fd);
  return Access::given;
}

std::optional<bool> read_synchronised() {
  timex question{};  // modes = 0: read only
  if (::adjtimex(&question) < 0) return std::nullopt;
  return (question.status & STA_UNSYNC) == 0;
}

/// A missing privilege is a fault if `realtime` is `enforce` (the daemon does not start), else a
/// warning (frames are late).
Finding missing(const HostFacts& facts, std::string meaning, std::string fix) {
  if (facts.policy == RealtimePolicy::enforce) {
    return bad(meaning + "; the daemon does not start, because \"realtime\" is \"enforce\"",
               std::move(fix));
  }
  return warning(std::move(meaning), std::move(fix));
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
  if (!facts.limits) return not_here("the system does not report a process's limits");
  const int needed = std::ranges::max(kThreadTable, {}, &ThreadRow::fifo_priority).fifo_priority;
  const Limits& limits = *facts.limits;
  if (limits.may_any_priority || limits.realtime_priority >= std::uint64_t(needed)) {
    return good(daemon_name(facts) + " may use the real-time priorities of the frame path");
  }
  return missing(facts,
                 fmt::format("{} may use real-time priorities up to {}, the frame path needs {}: "
                             "other programs delay frames",
                             daemon_name(facts), limits.realtime_priority, needed),
                 limits_fix(facts, "rtprio", "90"));
}

Finding judge_memory(const HostFacts& facts) {
  if (!facts.limits) return not_here("the system does not report a process's limits");
  if (facts.limits->may_lock_all || !facts.limits->locked_bytes) {
    return good(daemon_name(facts) + " may lock all its memory");
  }
  return missing(facts,
                 fmt::format("{} may lock only {} MiB of memory: page faults delay frames",
                             daemon_name(facts), *facts.limits->locked_bytes >> 20),
                 limits_fix(facts, "memlock", "unlimited"));
}

Finding judge_throttling(const HostFacts& facts) {
  constexpr double kMinShare = 0.9;  // of a CPU for real-time threads; the kernel's default is 0.95
  constexpr const char* kFix = "sudo sysctl -w kernel.sched_rt_runtime_us=950000";
  if (!facts.rt_runtime_us || !facts.rt_period_us || *facts.rt_period_us <= 0) {
    return not_here("kernel.sched_rt_runtime_us cannot be read here");
  }
  if (*facts.rt_runtime_us < 0) return good("the kernel does not throttle real-time threads");
  const double share = double(*facts.rt_runtime_us) / double(*facts.rt_period_us);
  const std::string says =
      fmt::format("real-time threads may use {:.0f} % of a CPU", 100.0 * share);
  if (share >= kMinShare) return good(says);
  return missing(facts, says + ": above that the kernel throttles them and frames are late", kFix);
}

Finding judge_governor(const HostFacts& facts) {
  if (facts.governors.empty()) return not_here("there is no CPU frequency scaling here");
  const std::string names = fmt::format("{}", fmt::join(facts.governors, ", "));
  if (facts.governors == std::vector<std::string>{"performance"}) {
    return good("all CPUs use the performance governor");
  }
  return warning(
      "the CPU frequency governor is " + names +
          ": CPUs slow down between frames, so frames are measured late",
      "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

Finding judge_sleep(const HostFacts& facts) {
  constexpr const char* kPath = "/dev/cpu_dma_latency";
  if (facts.dma_latency == Access::absent) {
    return not_here(fmt::format("{} does not exist", kPath));
  }
  if (facts.dma_latency == Access::given) {
    return good(fmt::format("{} is writable: a daemon can prevent deep CPU sleep", kPath));
  }
  const std::string meaning =
      fmt::format("{} is not writable for this user: CPU sleep states delay the frames", kPath);
  if (facts.of_service) {
    return not_here(meaning +
                    " of a daemon that it starts; the service has access through its group");
  }
  return missing(facts, meaning + " of a daemon that it starts; the service has access",
                 "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=misc && "
                 "sudo systemctl start ovwsd");
}

Finding judge_clock_source(const HostFacts& facts) {
  // Clock sources that the vDSO reads without a system call.
  constexpr std::array<std::string_view, 4> kVdsoSources{"tsc", "kvm-clock", "arch_sys_counter",
                                                         "hyperv_clocksource_tsc_page"};
  if (!facts.clock_source) return not_here("the kernel does not report its clock source");
  if (std::ranges::find(kVdsoSources, *facts.clock_source) != kVdsoSources.end()) {
    return good("the clock source is " + *facts.clock_source);
  }
  return warning(
      "the clock source is " + *facts.clock_source +
          ", which takes a microsecond or more to read; if the kernel log says that tsc is "
          "unstable, update the firmware",
      "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource");
}

Finding judge_synchronised(const HostFacts& facts) {
  if (!facts.clock_synchronised)
    return not_here("the kernel does not report whether its clock is synchronised");
  if (*facts.clock_synchronised) return good("the clock is synchronised to a time server");
  return warning(
      "the clock is not synchronised to a time server: times in messages cannot be "
      "compared with those of other machines",
      "sudo timedatectl set-ntp true");
}

}  // namespace

std::optional<Limits> parse_limits(std::string_view limits, std::string_view status) {
  constexpr unsigned kSysNice = 23, kIpcLock = 14;
  constexpr int kHexadecimal = 16;
  const std::string_view priority = word_behind(limits, "Max realtime priority");
  const std::string_view locked = word_behind(limits, "Max locked memory");
  const auto capabilities =
      number_from<std::uint64_t>(word_behind(status, "CapEff:"), kHexadecimal);
  if (priority.empty() || locked.empty() || !capabilities) return std::nullopt;
  Limits read;
  constexpr std::uint64_t kAnyPriority = 99;
  read.realtime_priority = number_from<std::uint64_t>(priority).value_or(kAnyPriority);
  read.locked_bytes = number_from<std::uint64_t>(locked);
  read.may_any_priority = (*capabilities >> kSysNice & 1) != 0;
  read.may_lock_all = (*capabilities >> kIpcLock & 1) != 0;
  return read;
}

HostFacts read_host(RealtimePolicy policy) {
  HostFacts facts;
  facts.policy = policy;
  const auto service = service_process();
  facts.of_service = service.has_value();
  facts.limits = limits_of(service.value_or("/proc/self"));
  facts.rt_runtime_us = number_of("/proc/sys/kernel/sched_rt_runtime_us");
  facts.rt_period_us = number_of("/proc/sys/kernel/sched_rt_period_us");
  facts.governors = read_governors();
  facts.dma_latency = read_dma_latency();
  facts.clock_source = word_of("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  facts.clock_synchronised = read_synchronised();
  return facts;
}

Findings answers(const HostFacts& facts) {
  constexpr Question<HostFacts> kQuestions[] = {
      {"realtime.priority", judge_priority},
      {"realtime.memory", judge_memory},
      {"realtime.throttling", judge_throttling},
      {"cpu.governor", judge_governor},
      {"cpu.sleep", judge_sleep},
      {"clock.source", judge_clock_source},
      {"clock.synchronised", judge_synchronised},
  };
  return answers<HostFacts>(kQuestions, facts);
}

}  // namespace ovws::examine
