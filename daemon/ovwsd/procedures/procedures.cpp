#include "daemon/ovwsd/procedures/procedures.hpp"

#include <chrono>
#include <exception>
#include <future>
#include <new>
#include <string>
#include <utility>

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kMaxIdle(50);

}  // namespace

void Procedures::start(const std::string& kind, Procedure procedure,
                       std::function<void(Result<int>)> done, Holds holds) {
  // Only the prepare thread knows whether the sensor is free.
  deps_.bench.keeper.after_changes(
      [this, kind, procedure = std::move(procedure), done = std::move(done), holds]() mutable {
        begin(kind, std::move(procedure), done, holds);
      });
}

void Procedures::begin(const std::string& kind, Procedure procedure,
                       const std::function<void(Result<int>)>& done, Holds holds) {
  auto run = std::make_shared<Run>();
  const std::weak_ptr<Run> weak_run = run;
  {
    const std::lock_guard lock(mutex_);
    if (ending_) return done(fail(Errc::refused, "", "the daemon is stopping"));
    if (run_) {
      return done(fail(Errc::refused, "",
                       "another job is running: wait until it ends, or call job.cancel"));
    }
    run_ = run;
    begun_ = true;  // do_work must not start the run before it is complete
  }
  auto free = holds != Holds::nothing ? deps_.bench.keeper.may_hold() : Result<void>{};
  if (!free) {
    release();
    return done(fail(free.error()));
  }
  run->job = deps_.bench.jobs.begin(
      kind,
      [weak_run] {
        if (const auto it = weak_run.lock()) it->stop = true;
      },
      [weak_run] {
        const auto it = weak_run.lock();
        return it ? it->progress.load() : 0.0;
      });
  run->procedure = std::move(procedure);
  run->bench = std::make_unique<Bench>(run->job, deps_.bench, run->stop, run->progress);
  run->holds = holds;
  if (holds != Holds::nothing) {
    deps_.bench.keeper.hold(Hold::of_job(run->job));
    deps_.on_job(holds, true);
  }
  done(run->job);
  {
    const std::lock_guard lock(mutex_);
    begun_ = false;
  }
  asked_.notify_one();
}

/// Marks the sensor as free and calls the callbacks of when_free.
void Procedures::release() {
  std::vector<std::function<void()>> waiting;
  {
    const std::lock_guard lock(mutex_);
    run_.reset();
    waiting.swap(waiting_);
  }
  for (const auto& then : waiting) then();
}

void Procedures::end_soon() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  if (run_) run_->stop = true;
}

void Procedures::when_free(std::function<void()> then) {
  {
    const std::lock_guard lock(mutex_);
    if (run_) return waiting_.push_back(std::move(then));
  }
  then();
}

bool Procedures::do_work() {
  std::shared_ptr<Run> run;
  {
    std::unique_lock lock(mutex_);
    if (!asked_.wait_for(lock, kMaxIdle, [this] { return run_ && !begun_; })) return false;
    begun_ = true;
    run = run_;
  }
  finish(run, carry_out(*run));
  return true;
}

/// Runs the procedure. Turns exceptions into errors: images of many megapixels may exceed the
/// locked memory.
Result<nlohmann::json> Procedures::carry_out(Run& run) {
  try {
    return run.procedure(*run.bench);
  } catch (const std::bad_alloc&) {
    return fail(Errc::unavailable, "",
                "there is not enough memory: choose a smaller region of interest");
  } catch (const std::exception& error) {  // the job fails and releases the sensor
    return fail(Errc::internal, "",
                std::string("internal error of the daemon: ") + error.what() +
                    "; run the job again, and report this message if it recurs");
  }
}

/// Restores camera and hologram and releases the sensor before the job ends, because a client may
/// start the next job as soon as a job has ended. A disk that does not answer delays only the end
/// of the job.
void Procedures::finish(const std::shared_ptr<Run>& run, const Result<nlohmann::json>& result) {
  run->bench->restore_camera();
  auto given_back = std::make_shared<std::promise<void>>();
  auto done = given_back->get_future();
  deps_.bench.keeper.release(Hold::of_job(run->job), [given_back] { given_back->set_value(); });
  given_back.reset();
  done.wait();  // returns also if the prepare thread has ended, which breaks the promise
  const int job = run->job;
  {
    const std::lock_guard lock(mutex_);
    begun_ = false;
  }
  if (run->holds != Holds::nothing) deps_.on_job(run->holds, false);
  release();
  // The callback keeps `run` alive, because `run` provides the progress until the job has ended.
  run->bench->pending_files()->when_none([run, &jobs = deps_.bench.jobs, job, result] {
    if (result) return jobs.finish(job, *result);
    jobs.fail_job(job, result.error());
  });
}

}  // namespace ovws
