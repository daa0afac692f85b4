/// Long commands that show pictures and look at what the camera makes of them, one at a time, in a
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

/// Returns what the job's result shall be.
using Procedure = std::function<Result<nlohmann::json>(Bench&)>;

struct ProceduresDeps {
  BenchDeps bench;
  /// Any thread: a job began (true) or ended (false).
  std::function<void(bool)> on_job;
};

/// The agent of the procedure thread.
class Procedures : public Agent {
 public:
  explicit Procedures(ProceduresDeps deps) : deps_(std::move(deps)) {}

  /// Thread-safe: the job's number; the sensor is lent to it from now on. Errc::refused if one
  /// runs.
  void start(const std::string& kind, Procedure procedure, std::function<void(Result<int>)> done);
  /// Thread-safe: calls `then` when no procedure has the sensor, in the procedure thread or at
  /// once.
  void when_free(std::function<void()> then);
  /// Thread-safe: what runs ends within a fraction of a second.
  void end_soon();

  bool do_work() override;

 private:
  struct Run {
    int job = 0;
    Procedure procedure;
    std::atomic<bool> stop{false};
    std::atomic<double> progress{0.0};
    std::unique_ptr<Bench> bench;
  };
  void begin(const std::string& kind, Procedure procedure,
             const std::function<void(Result<int>)>& done);
  Result<nlohmann::json> carry_out(Run& run);
  void finish(const std::shared_ptr<Run>& run, const Result<nlohmann::json>& result);
  void release();

  ProceduresDeps deps_;
  std::mutex mutex_;
  std::condition_variable asked_;
  std::shared_ptr<Run> run_;  ///< none: nothing runs or waits to run
  std::vector<std::function<void()>> waiting_;
  bool begun_ = false;  ///< run_ is being carried out
  bool ending_ = false;
};

}  // namespace ovws
