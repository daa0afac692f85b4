#include <fcntl.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "daemon/ovws/doctor/host.hpp"
#include "daemon/ovws/doctor/system_files.hpp"

namespace ovws::doctor {
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

std::optional<std::uint64_t> number(std::string_view word, int base) {
  std::uint64_t value = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value, base);
  if (word.empty() || read.ec != std::errc{} || read.ptr != word.data() + word.size()) {
    return std::nullopt;
  }
  return value;
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
  // Try to open it: permissions alone do not decide access. Opening sets no latency limit; only a
  // write does.
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

}  // namespace

std::optional<Limits> parse_limits(std::string_view limits, std::string_view status) {
  constexpr unsigned kSysNice = 23, kIpcLock = 14;
  constexpr int kDecimal = 10, kHexadecimal = 16;
  const std::string_view priority = word_behind(limits, "Max realtime priority");
  const std::string_view locked = word_behind(limits, "Max locked memory");
  const auto capabilities = number(word_behind(status, "CapEff:"), kHexadecimal);
  if (priority.empty() || locked.empty() || !capabilities) return std::nullopt;
  Limits read;
  constexpr std::uint64_t kAnyPriority = 99;
  read.realtime_priority = number(priority, kDecimal).value_or(kAnyPriority);
  read.locked_bytes = number(locked, kDecimal);
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

}  // namespace ovws::doctor
