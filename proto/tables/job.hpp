/// Field tables of jobs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/field_json.hpp"

namespace ovws {

enum class JobState { running, done, failed, cancelled };
template <>
struct Names<JobState> {
  static const std::vector<std::string>& all() {
    static const std::vector<std::string> names{"running", "done", "failed", "cancelled"};
    return names;
  }
};

/// Error of a failed job, in the form of a JSON-RPC error.
struct ErrorReport {
  int code = 0;
  std::string message;
  JsonObject data;
};
template <>
struct Table<ErrorReport> {
  static constexpr const char* kName = "ErrorReport";
  static constexpr auto kFields =
      Fields{field("code", &ErrorReport::code, "error code, as in an error reply"),
             field("message", &ErrorReport::message, "what is wrong, in one sentence"),
             field("data", &ErrorReport::data, "details: field, reason, limits")};
};

struct JobReport {
  int job = 0;
  std::string kind;  ///< the method that started it
  JobState state = JobState::running;
  double progress = 0.0;       ///< 0 to 1
  Json result;                 ///< null unless done
  std::optional<Error> error;  ///< of a failed job
};
std::optional<ErrorReport> job_error(const JobReport& job);
template <>
struct Table<JobReport> {
  static constexpr const char* kName = "JobReport";
  static constexpr auto kFields =
      Fields{field("job", &JobReport::job, "number of the job", limits::kJob),
             field("kind", &JobReport::kind, "the method that started it"),
             field("state", &JobReport::state, "state of the job"),
             field("progress", &JobReport::progress, "fraction done, 0 to 1", {0, 1}),
             field("result", &JobReport::result, "result of the job; null unless done"),
             computed<JobReport>("error", job_error, "why it failed; null unless failed")};
};

/// Number of a job: result of the methods that start one, params of `job.get` and `job.cancel`.
struct JobNumber {
  int job = 0;
};
template <>
struct Table<JobNumber> {
  static constexpr const char* kName = "JobNumber";
  static constexpr auto kFields =
      Fields{field("job", &JobNumber::job, "number of the job", limits::kJob).mandatory()};
};

}  // namespace ovws
