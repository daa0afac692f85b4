/// Jobs: long commands, each with a number, progress reports and an end event.
#pragma once

#include <atomic>
#include <map>
#include <memory>
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

/// Job table: numbers jobs and reports their state; Procedures runs one job at a time. Remembers
/// the last 100 jobs. Thread-safe.
class Jobs {
 public:
  explicit Jobs(Events& events) : events_(events) {}

  /// What a running job shares with all threads.
  struct Live {
    std::atomic<bool> stop{false};      ///< the job must end soon
    std::atomic<double> progress{0.0};  ///< 0 .. 1
  };

  /// Registers a running job and returns its number. `cancel(id)` sets `stop` of `live`.
  int begin(std::string kind, std::shared_ptr<Live> live);
  /// Emits an event each time the progress of a running job has passed another quarter.
  void report_progress(int id);
  /// Ends a job: with its result, or as failed. One that was cancelled has neither.
  void finish(int id, Result<nlohmann::json> result);
  /// Stops a job and returns its report: it runs until `end_cancelled`. A job that has ended, or
  /// whose result is in use, is not changed. Errc::invalid if no job has this number.
  Result<JobReport> cancel(int id);
  /// Marks the job's result as in use; from then on the job cannot be cancelled. Returns false if
  /// the job has already ended.
  bool use_result(int id);
  Result<JobReport> get(int id) const;
  /// The latest job failure since the daemon's start, kept longer than the job's entry. A later job
  /// of the failed job's kind clears the failure if it succeeds.
  std::optional<StatusMessage::FailedJob> last_failed() const;
  bool runs(int id) const;  ///< false once the job has finished, failed or been told to stop
  /// Ends a job that was cancelled, when its procedure has ended; its files may still be written.
  /// Returns false for another one.
  bool end_cancelled(int id);

 private:
  struct Entry {
    JobReport job;
    std::shared_ptr<Live> live;
    int reported_quarters = 0;
    bool result_in_use = false, cancelled = false;
    bool goes_on() const { return job.state == JobState::running && !cancelled; }
  };
  // Call these with mutex_ locked.
  void drop_oldest();
  void note_end(const JobReport& job);
  void end(Entry& entry, Result<nlohmann::json> result);

  Events& events_;
  mutable std::mutex mutex_;
  std::map<int, Entry> jobs_;
  std::vector<StatusMessage::FailedJob> failed_;  ///< at most one per kind, latest last
  int next_id_ = 1;
};

}  // namespace ovws
