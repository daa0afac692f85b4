/// Health summary of the bench for the head of the page.
#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ovws::web {

/// The newest messages and counters. A message is null until the first one arrives.
struct BenchFacts {
  nlohmann::json status;
  nlohmann::json wavefront;
  double status_age_s = 0.0;
  double wavefront_age_s = 0.0;
  std::int64_t lost_lately = 0;    ///< frames that the camera lost in the last 10 s
  std::int64_t missed_lately = 0;  ///< frames that took longer than a period in the last 10 s
  int slow_statuses = 0;           ///< successive status messages with a slow_camera
};

enum class Wellness { good, note, warning, bad };

struct HealthFinding {
  Wellness wellness = Wellness::good;
  std::string text;  ///< the problem, and what to do
  /// What the button of the finding does: {"label", "calls": [{"method", "params"}]} calls methods
  /// of the daemon in order, {"label", "section"} leads to the panel of the page with this id. Null
  /// only if nothing is wrong.
  nlohmann::json action;
};

/// Examines the bench. Returns all findings, the worst first; a single `good` finding if nothing is
/// wrong.
std::vector<HealthFinding> examine_bench(const BenchFacts& facts);

/// The findings as a JSON array of {wellness, text, action} for the browser.
nlohmann::json findings_json(const std::vector<HealthFinding>& findings);

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

}  // namespace ovws::web
