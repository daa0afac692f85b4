/// Questions that a daemon's status and newest frame answer: for ovws doctor and the live page.
#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/examine/finding.hpp"

namespace ovws::examine {

struct DaemonFacts {
  std::string endpoint;
  std::optional<nlohmann::json> status;  ///< the reply to system.status, or the newest message
  nlohmann::json wavefront;              ///< the newest message; null: none
  bool refused = false;                  ///< no status, because the daemon answered with an error
  std::string why;                       ///< why there is no status
  bool asks_for_keys = false;            ///< clients need keys: the configuration sets a secret key
  std::string own_version;               ///< version of this program
  nlohmann::json config;                 ///< the reply to config.get; null: none
  std::optional<nlohmann::json> levels;  ///< the reply to slm.verify; none: not called, or refused
  std::string why_no_levels;             ///< why there is none although it shows holograms
  // Of a program that follows the daemon's messages.
  bool is_followed = false;  ///< a status is missed if none comes
  double status_age_s = 0.0, wavefront_age_s = 0.0;
  std::int64_t lost_lately = 0;    ///< frames that the camera lost in the last 10 s
  std::int64_t missed_lately = 0;  ///< frames that took longer than a period in the last 10 s
  int slow_statuses = 0;           ///< successive status messages with a slow_camera
};

/// Answers what the asker asks of a daemon.
Findings answers(const DaemonFacts& facts, Asker asker);

/// The findings for the head of the live page, the worst first; a single `good` one if nothing is
/// wrong. The action of a finding is what its button does: {"label", "calls": [{"method",
/// "params"}]} calls methods of the daemon in order, {"label", "section"} leads to the panel of the
/// page with this id. Null only if nothing is wrong.
Findings page_findings(const DaemonFacts& facts);

/// Whether the daemon answered and has the SLM's output open.
bool shows_holograms(const DaemonFacts& facts);
/// Why slm.verify would disturb this bench: it delays holograms. Empty: it does not.
std::string why_not_verify(const DaemonFacts& facts);

/// Why the daemon of this `status` cannot measure wavefronts now, and what to do; empty: it can.
std::string why_not_ready(const nlohmann::json& status);

/// Increase of a counter of `status` in the last ten seconds. Use it from one thread at a time.
class RiseLately {
 public:
  /// `t_s`: time of a monotonic clock. A count below the previous count means that the daemon
  /// restarted.
  void add(double t_s, std::int64_t count);
  std::int64_t rise() const;

 private:
  struct Sample {
    double t_s;
    std::int64_t count;
  };
  std::deque<Sample> samples_;
};

}  // namespace ovws::examine
