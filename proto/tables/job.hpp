/// Field tables of jobs: the JSON fields of their messages, for reading, writing and schemas.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/field_json.hpp"

namespace ovws {

enum class JobState { running, done, failed, cancelled };
template <>
inline constexpr NamesOf kNames<JobState> = texts<"running", "done", "failed", "cancelled">;

/// Error of a failed job, in the form of a JSON-RPC error.
struct ErrorReport {
  int code = 0;
  std::string message;
  JsonObject data;
};
template <>
inline constexpr auto kTable<ErrorReport> =
    Fields{"ErrorReport", field<&ErrorReport::code>("error code, as in an error reply"),
           field<&ErrorReport::message>("what is wrong, in one sentence"),
           field<&ErrorReport::data>("details: field, reason, limits")};

struct JobReport {
  int job = 0;
  std::string kind;  ///< name of the method that started the job
  JobState state = JobState::running;
  double progress = 0.0;       ///< 0 to 1
  Json result;                 ///< null unless done
  std::optional<Error> error;  ///< why a failed job failed
};
std::optional<ErrorReport> job_error(const JobReport& job);
template <>
inline constexpr auto kTable<JobReport> =
    Fields{"JobReport",
           field<&JobReport::job>("number of the job", limits::kJob),
           field<&JobReport::kind>("the method that started it"),
           field<&JobReport::state>("state of the job"),
           field<&JobReport::progress>("fraction done, 0 to 1", {0, 1}),
           field<&JobReport::result>("result of the job; null unless done"),
           computed("error", job_error, "why it failed; null unless failed")};

/// Number of a job: result of the methods that start one, params of `job.get` and `job.cancel`.
struct JobNumber {
  int job = 0;
};
template <>
inline constexpr auto kTable<JobNumber> =
    Fields{"JobNumber", field<&JobNumber::job>("number of the job", limits::kJob).mandatory()};

}  // namespace ovws
