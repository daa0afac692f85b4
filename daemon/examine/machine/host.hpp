/// Host checks of `ovws doctor`: real-time limits, CPU power management and the clock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "daemon/examine/machine/finding.hpp"

namespace ovws::doctor {

/// Resource limits of a process: real-time priority (RLIMIT_RTPRIO) and locked memory.
struct Limits {
  std::uint64_t realtime_priority = 0;
  std::optional<std::uint64_t> locked_bytes = 0;  ///< none: unlimited
  bool may_any_priority = false;                  ///< CAP_SYS_NICE
  bool may_lock_all = false;                      ///< CAP_IPC_LOCK
};

enum class Access { absent, refused, given };

struct HostFacts {
  RealtimePolicy policy = RealtimePolicy::ignore;
  std::optional<Limits> limits;
  bool of_service = false;  ///< `limits` are those of the running service; else of this process
  std::optional<std::int64_t> rt_runtime_us, rt_period_us;
  std::vector<std::string> governors;  ///< distinct names of CPU governors; empty: no scaling
  Access dma_latency = Access::absent;
  std::optional<std::string> clock_source;
  std::optional<bool> clock_synchronised;
};

/// Parses the texts of /proc/PID/limits and /proc/PID/status; none: unexpected format.
std::optional<Limits> parse_limits(std::string_view limits, std::string_view status);

HostFacts read_host(RealtimePolicy policy);
Findings judge(const HostFacts& facts);

}  // namespace ovws::doctor
