/// Runs procedures: long measurements that show holograms and evaluate frames, one at a time, in a
/// thread of their own.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/rt/agent.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// A procedure: measures with the bench and returns the job's result as JSON.
using Procedure = std::function<Result<nlohmann::json>(Bench&)>;

/// Agent of the procedure thread: runs one procedure at a time.
class Procedures : public Agent {
 public:
  explicit Procedures(BenchDeps deps) : deps_(std::move(deps)) {}

  struct Start {
    std::string kind;
    Procedure procedure;
    /// Whether it can start, judged when it has its lease; empty: always.
    std::function<Result<void>(const SensorSnapshot&)> can{};
  };
  /// Starts a job, which has `lease`, one of a job, until it ends. Thread-safe. Calls `done` in the
  /// prepare thread with the job's number, and begins the procedure after `done` has returned; or
  /// with the error of `can`. While the daemon stops, the procedure is stopped from its beginning.
  void start(LeasePtr lease, Start what, std::function<void(Result<int>)> done);
  /// Calls `then` when the job's lease has ended and what it had changed for itself is restored: at
  /// once, or later in the procedure thread. Thread-safe.
  void when_over(int job, std::function<void()> then);
  /// Stops every job within a fraction of a second, also one that starts later. Thread-safe.
  void end_soon();

  bool do_work() override;

 private:
  struct Run {
    int job = 0;
    LeasePtr lease;
    Procedure procedure;
    std::shared_ptr<Jobs::Live> live = std::make_shared<Jobs::Live>();
    std::unique_ptr<Bench> bench;
    bool told = false;  ///< its number was told: it may run
    Result<nlohmann::json> result;
    std::vector<std::function<void()>> waiting{};  ///< of when_over
  };
  void begin(const LeasePtr& lease, Start what, const std::function<void(Result<int>)>& done);
  void finish(const std::shared_ptr<Run>& run);
  void restore_sensor(Run& run);

  BenchDeps deps_;
  std::mutex mutex_;
  std::condition_variable asked_;
  /// The job that runs, and one more that waits while it ends. `told` and `waiting` of each are
  /// guarded by mutex_.
  std::vector<std::shared_ptr<Run>> runs_;
  bool ending_ = false;
};

}  // namespace ovws
