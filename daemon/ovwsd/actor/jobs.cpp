#include "daemon/ovwsd/actor/jobs.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxRemembered = 100;

nlohmann::json event_data(int id, JobState state, double progress) {
  return {{"job", id}, {"state", to_json(state)}, {"progress", progress}};
}

const char* end_text(JobState state) {
  if (state == JobState::failed) return "has failed";
  return state == JobState::cancelled ? "was cancelled" : "is done";
}

}  // namespace

int Jobs::begin(std::string kind, std::shared_ptr<Live> live) {
  int id = 0;
  {
    const std::lock_guard lock(mutex_);
    id = next_id_++;
    Entry& entry = jobs_[id];
    entry.job.job = id;
    entry.job.kind = kind;
    entry.live = std::move(live);
    drop_oldest();
  }
  events_.emit("job", Severity::info, fmt::format("job {} ({}) is running", id, kind),
               event_data(id, JobState::running, 0.0));
  return id;
}

/// Drops the oldest ended job above kMaxRemembered. Running jobs are kept, because a client waits
/// for their end.
void Jobs::drop_oldest() {
  if (jobs_.size() <= kMaxRemembered) return;
  const auto ended = std::find_if(jobs_.begin(), jobs_.end(), [](const auto& one) {
    return one.second.job.state != JobState::running;
  });
  if (ended != jobs_.end()) jobs_.erase(ended);
}

void Jobs::report_progress(int id) {
  constexpr int kQuarters = 4;
  // Hold the lock while the event is emitted, so that the job's end event cannot come first.
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second.job.state != JobState::running) return;
  const int quarters = int(found->second.live->progress * kQuarters);
  if (quarters >= kQuarters) return;
  if (quarters <= std::exchange(found->second.reported_quarters, quarters)) return;
  events_.emit(
      "job", Severity::info,
      fmt::format("job {} ({}) is at {} %", id, found->second.job.kind, 100 * quarters / kQuarters),
      event_data(id, JobState::running, double(quarters) / kQuarters));
}

void Jobs::finish(int id, Result<nlohmann::json> result) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found != jobs_.end()) end(found->second, std::move(result));
}

Result<JobReport> Jobs::cancel(int id) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found != jobs_.end() && found->second.goes_on() && !found->second.result_in_use) {
      found->second.cancelled = true;
      found->second.live->stop = true;
    }
  }
  return get(id);
}

Result<JobReport> Jobs::get(int id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) {
    return fail(Errc::invalid, "job", fmt::format("there is no job {}", id));
  }
  JobReport job = found->second.job;
  if (job.state == JobState::running) job.progress = found->second.live->progress;
  return job;
}

std::optional<StatusMessage::FailedJob> Jobs::last_failed() const {
  const std::lock_guard lock(mutex_);
  return failed_.empty() ? std::nullopt : std::optional(failed_.back());
}

/// Records a failed job, and clears the failure of its kind after a success. A cancelled job leaves
/// the previous failure in place.
void Jobs::note_end(const JobReport& job) {
  if (job.state == JobState::cancelled) return;
  std::erase_if(failed_, [&job](const auto& one) { return one.kind == job.kind; });
  if (job.state != JobState::failed) return;
  failed_.push_back({job.job, job.kind, job.error->field, job.error->reason, utc_ns()});
}

bool Jobs::use_result(int id) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || !found->second.goes_on()) return false;
  return found->second.result_in_use = true;
}

bool Jobs::runs(int id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  return found != jobs_.end() && found->second.goes_on();
}

bool Jobs::end_cancelled(int id) {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || !found->second.cancelled) return false;
  end(found->second, nullptr);
  return true;
}

void Jobs::end(Entry& entry, Result<nlohmann::json> result) {
  JobReport& job = entry.job;
  if (job.state != JobState::running) return;
  job.progress = entry.live->progress;
  if (entry.cancelled) {
    job.state = JobState::cancelled;
  } else if (result) {
    job.state = JobState::done;
    job.progress = 1.0;
    job.result = std::move(*result);
  } else {
    job.state = JobState::failed;
    job.error = std::move(result.error());
  }
  note_end(job);
  const std::string text = fmt::format("job {} ({}) {}{}", job.job, job.kind, end_text(job.state),
                                       job.error ? ": " + job.error->reason : "");
  const auto severity = job.error ? Severity::error : Severity::info;
  events_.emit("job", severity, text, event_data(job.job, job.state, job.progress));
}

}  // namespace ovws
