/// Long commands: each has a number, a progress, and an end that is told.
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
#include "proto/tables/job.hpp"
#include "proto/tables/status.hpp"

namespace ovws {

/// Thread-safe. One job runs at a time; the last 100 are remembered.
class Jobs {
 public:
  explicit Jobs(Events& events) : events_(events) {}

  /// `cancel` is called by `cancel(id)`, `progress` by `get`; both from any thread, without our
  /// lock held.
  int begin(std::string kind, std::function<void()> cancel, std::function<double()> progress);
  /// An event when a running job has come past the next quarter.
  void tell_progress(int id);
  void finish(int id, nlohmann::json result);
  void fail_job(int id, Error error);
  /// Errc::invalid if there is no such job; a job that has ended stays as it is.
  Result<JobReport> cancel(int id);
  Result<JobReport> get(int id) const;
  /// The one that failed last since the start, also if it is not remembered any more. A failure is
  /// forgotten when a job of the same kind is done.
  std::optional<StatusMessage::FailedJob> last_failed() const;
  bool runs(int id) const;  ///< false once it was finished, failed or cancelled

 private:
  struct Entry {
    JobReport job;
    std::function<void()> cancel;
    std::function<double()> progress;
    int told_quarters = 0;
  };
  // Call with mutex_ locked.
  void forget_oldest();
  void note_end(const JobReport& job);
  bool end(int id, JobState state, nlohmann::json result, std::optional<Error> error);

  Events& events_;
  mutable std::mutex mutex_;
  std::map<int, Entry> jobs_;
  std::vector<StatusMessage::FailedJob> failed_;  ///< at most one of a kind, the latest at the end
  int next_id_ = 1;
};

}  // namespace ovws
