/// Runs procedures: long measurements that show holograms and evaluate frames, one at a time, in a
/// thread of their own.
#pragma once

#include <atomic>
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

/// What a job holds. `hologram`: the sensor, but clients may change the camera's settings.
/// `nothing`: it only watches frames, and blocks nothing but other jobs.
enum class Holds { sensor, hologram, nothing };

struct ProceduresDeps {
  BenchDeps bench;
  /// Called in any thread when a job that holds something has begun (true) or ended (false).
  std::function<void(Holds, bool)> on_job;
};

/// Agent of the procedure thread: runs one procedure at a time.
class Procedures : public Agent {
 public:
  explicit Procedures(ProceduresDeps deps) : deps_(std::move(deps)) {}

  /// Starts a job, which holds the sensor until the job ends, unless it `holds` nothing.
  /// Thread-safe. Calls `done` in the prepare thread with the job's number, and begins the
  /// procedure after `done` has returned. Errc::refused: another job is running, the loop or a
  /// reload holds the sensor that the job needs, or the daemon is stopping.
  void start(const std::string& kind, Procedure procedure, std::function<void(Result<int>)> done,
             Holds holds = Holds::sensor);
  /// Calls `then` when no procedure runs: at once, or later in the procedure thread.
  /// Thread-safe.
  void when_free(std::function<void()> then);
  /// Refuses new jobs and stops the running job within a fraction of a second. Thread-safe.
  void end_soon();

  bool do_work() override;

 private:
  struct Run {
    int job = 0;
    Holds holds = Holds::sensor;
    Procedure procedure;
    std::atomic<bool> stop{false};
    std::atomic<double> progress{0.0};
    std::unique_ptr<Bench> bench;
  };
  void begin(const std::string& kind, Procedure procedure,
             const std::function<void(Result<int>)>& done, Holds holds);
  Result<nlohmann::json> carry_out(Run& run);
  void finish(const std::shared_ptr<Run>& run, const Result<nlohmann::json>& result);
  void release();

  ProceduresDeps deps_;
  std::mutex mutex_;
  std::condition_variable asked_;
  std::shared_ptr<Run> run_;  ///< null: no job runs or waits to run
  std::vector<std::function<void()>> waiting_;
  bool begun_ = false;  ///< true while run_ is prepared or running
  bool ending_ = false;
};

}  // namespace ovws
