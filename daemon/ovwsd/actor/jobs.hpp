/// Jobs: long commands, each with a number, a progress, and a reported end.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "proto/status_message.hpp"
#include "proto/tables/job.hpp"

namespace ovws {

/// Thread-safe. Numbers and reports jobs; Procedures runs them, one at a time. The last 100 jobs
/// are remembered.
class Jobs {
 public:
  explicit Jobs(Events& events) : events_(events) {}

  /// Registers a running job and returns its number. `cancel(id)` calls `cancel` and `get` calls
  /// `progress`, from any thread and without our lock.
  int begin(std::string kind, std::function<void()> cancel, std::function<double()> progress);
  /// Emits an event when a running job has passed the next quarter.
  void report_progress(int id);
  void finish(int id, nlohmann::json result);
  void fail_job(int id, Error error);
  /// Errc::invalid if there is no such job. A job that has ended, or whose result is in use, stays
  /// as it is.
  Result<JobReport> cancel(int id);
  /// The job's result is adopted now: from here on the job is not cancelled. False if it has ended.
  bool use_result(int id);
  Result<JobReport> get(int id) const;
  /// The latest failure since the daemon's start, kept longer than the job itself. A job of the
  /// same kind that succeeds clears it.
  std::optional<StatusMessage::FailedJob> last_failed() const;
  bool runs(int id) const;  ///< false once it was finished, failed or cancelled

 private:
  struct Entry {
    JobReport job;
    std::function<void()> cancel;
    std::function<double()> progress;
    int reported_quarters = 0;
    bool result_in_use = false;
  };
  // Call with mutex_ locked.
  void drop_oldest();
  void note_end(const JobReport& job);
  bool end(int id, JobState state, nlohmann::json result, std::optional<Error> error);

  Events& events_;
  mutable std::mutex mutex_;
  std::map<int, Entry> jobs_;
  std::vector<StatusMessage::FailedJob> failed_;  ///< at most one per kind, the latest last
  int next_id_ = 1;
};

}  // namespace ovws
