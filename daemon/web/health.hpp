/// Whether the bench is well, as a person at a glance wants to know it.
#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ovws::web {

/// What is known of the bench now. Null where no such message came yet.
struct BenchFacts {
  nlohmann::json status;
  nlohmann::json wavefront;
  double status_age_s = 0.0;
  double wavefront_age_s = 0.0;
  std::int64_t lost_lately = 0;    ///< frames that the camera lost, in the last kLately
  std::int64_t missed_lately = 0;  ///< frames later than their period, in the last kLately
};

enum class Wellness { good, note, warning, bad };

struct HealthFinding {
  Wellness wellness = Wellness::good;
  std::string text;  ///< what is so, and what to do
};

/// The worst first; of one finding "good" if nothing is wrong.
std::vector<HealthFinding> examine_bench(const BenchFacts& facts);

/// {wellness, text} of each, as a browser gets them.
nlohmann::json findings_json(const std::vector<HealthFinding>& findings);

/// By how much a counter of `status` rose in the last ten seconds. One thread at a time.
class RiseLately {
 public:
  /// `t_s`: any clock that only moves on. A counter that fell is that of a new daemon.
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
