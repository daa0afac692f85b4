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

int Jobs::begin(std::string kind, std::function<void()> cancel, std::function<double()> progress) {
  int id = 0;
  {
    const std::lock_guard lock(mutex_);
    id = next_id_++;
    Entry& entry = jobs_[id];
    entry.job.job = id;
    entry.job.kind = kind;
    entry.cancel = std::move(cancel);
    entry.progress = std::move(progress);
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
  const auto now = get(id);
  if (!now || now->state != JobState::running) return;
  const int quarters = int(now->progress * kQuarters);
  // Hold the lock while the event is emitted, so that the job's end event cannot come first.
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second.job.state != JobState::running) return;
  if (quarters >= kQuarters) return;
  if (quarters <= std::exchange(found->second.reported_quarters, quarters)) return;
  events_.emit("job", Severity::info,
               fmt::format("job {} ({}) is at {} %", id, now->kind, 100 * quarters / kQuarters),
               event_data(id, JobState::running, double(quarters) / kQuarters));
}

void Jobs::finish(int id, nlohmann::json result) {
  end(id, JobState::done, std::move(result), std::nullopt);
}

void Jobs::fail_job(int id, Error error) {
  end(id, JobState::failed, nullptr, std::move(error));
}

Result<JobReport> Jobs::cancel(int id) {
  std::function<void()> cancel;
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found != jobs_.end() && found->second.goes_on() && !found->second.result_in_use) {
      found->second.cancelled = true;
      cancel = found->second.cancel;
    }
  }
  if (cancel) cancel();
  return get(id);
}

Result<JobReport> Jobs::get(int id) const {
  JobReport job;
  std::function<double()> progress;
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) {
      return fail(Errc::invalid, "job", fmt::format("there is no job {}", id));
    }
    job = found->second.job;
    progress = found->second.progress;
  }
  if (job.state == JobState::running) job.progress = progress();
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
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end() || !found->second.cancelled) return false;
  }
  end(id, JobState::cancelled, nullptr, std::nullopt);
  return true;
}

void Jobs::end(int id, JobState state, nlohmann::json result, std::optional<Error> error) {
  const auto now = get(id);
  double progress = now ? now->progress : 0.0;
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second.job.state != JobState::running) return;
  JobReport& job = found->second.job;
  if (found->second.cancelled) {
    state = JobState::cancelled;
    result = nullptr;
    error.reset();
  }
  job.state = state;
  if (state == JobState::done) progress = 1.0;
  job.progress = progress;
  job.result = std::move(result);
  job.error = error;
  note_end(job);
  const std::string text = fmt::format("job {} ({}) {}{}", id, job.kind, end_text(state),
                                       error ? ": " + error->reason : "");
  const auto severity = state == JobState::failed ? Severity::error : Severity::info;
  events_.emit("job", severity, text, event_data(id, state, progress));
}

}  // namespace ovws
