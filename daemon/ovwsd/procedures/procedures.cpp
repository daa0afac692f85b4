#include "daemon/ovwsd/procedures/procedures.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <future>
#include <new>
#include <string>
#include <utility>

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kMaxIdle(50);

/// Turns exceptions of the step into errors: images of many megapixels may exceed the locked
/// memory.
template <class Step>
Result<nlohmann::json> carry_out(const Step& step) {
  try {
    return step();
  } catch (const std::bad_alloc&) {
    return fail(Errc::unavailable, "",
                "there is not enough memory: choose a smaller region of interest");
  } catch (const std::exception& error) {  // the job fails and releases the sensor
    return fail(Errc::internal, "",
                std::string("internal error of the daemon: ") + error.what() +
                    "; run the job again, and report this message if it recurs");
  }
}

}  // namespace

void Procedures::start(LeasePtr lease, Start what, std::function<void(Result<int>)> done) {
  Lease& taken = *lease;
  taken.begin([this, lease = std::move(lease), what = std::move(what),
               done = std::move(done)]() mutable { begin(lease, std::move(what), done); });
}

void Procedures::begin(const LeasePtr& lease, Start what,
                       const std::function<void(Result<int>)>& done) {
  if (what.can) {
    if (const auto may = what.can(*deps_.keeper.snapshot()); !may) {
      lease->end();
      return done(fail(may.error()));
    }
  }
  auto run = std::make_shared<Run>();
  {
    const std::lock_guard lock(mutex_);  // before the job is known to others: they may cancel it
    run->job = deps_.jobs.begin(what.kind, run->live);
    run->lease = lease;
    run->procedure = std::move(what.procedure);
    run->bench = std::make_unique<Bench>(run->job, deps_, *run->live);
    if (ending_) run->live->stop = true;
    runs_.push_back(run);
  }
  done(run->job);
  {
    const std::lock_guard lock(mutex_);
    run->told = true;
  }
  asked_.notify_one();
}

void Procedures::end_soon() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  for (const auto& run : runs_) run->live->stop = true;
}

void Procedures::when_over(int job, std::function<void()> then) {
  {
    const std::lock_guard lock(mutex_);
    const auto at = std::ranges::find(runs_, job, [](const auto& run) { return run->job; });
    if (at != runs_.end()) return (*at)->waiting.push_back(std::move(then));
  }
  then();
}

bool Procedures::do_work() {
  std::shared_ptr<Run> run;
  {
    std::unique_lock lock(mutex_);
    const auto is_told = [this] { return !runs_.empty() && runs_.front()->told; };
    if (!asked_.wait_for(lock, kMaxIdle, is_told)) return false;
    run = runs_.front();
    run->told = false;  // it is carried out once, whatever happens
  }
  run->result = carry_out([&run] { return run->procedure(*run->bench); });
  finish(run);
  return true;
}

/// Restores camera and hologram and ends the lease before the job ends, because a client may start
/// the next job as soon as a job has ended. A disk that does not answer delays only the end of the
/// job.
void Procedures::finish(const std::shared_ptr<Run>& run) {
  const auto restored = carry_out([&] {
    run->bench->restore_camera();
    restore_sensor(*run);
    return nlohmann::json();
  });
  if (!restored && run->result) run->result = fail(restored.error());
  std::exchange(run->lease, nullptr)->end();
  std::vector<std::function<void()>> waiting;
  {
    const std::lock_guard lock(mutex_);
    std::erase(runs_, run);
    waiting.swap(run->waiting);
  }
  (void)deps_.jobs.end_cancelled(run->job);
  for (const auto& then : waiting) then();
  run->bench->take_end()->then = [run, &jobs = deps_.jobs] {
    jobs.finish(run->job, std::move(run->result));
  };
}

/// Has the prepare thread restore what the job had changed for itself.
void Procedures::restore_sensor(Run& run) {
  if (!run.lease->has_sensor()) return;
  auto restored = std::make_shared<std::promise<void>>();
  auto done = restored->get_future();
  deps_.keeper.take_turn(Holder::nobody, [restored] { restored->set_value(); });
  restored.reset();
  done.wait();  // returns also if the prepare thread has ended, which breaks the promise
}

}  // namespace ovws
