/// Archive of gain sweeps. Stores each cell as soon as it is measured, so that an interrupted sweep
/// can continue. A run has a header file, and a file for each reference, cell and image.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/store/daemon_store.hpp"
#include "proto/tables/experiment.hpp"

namespace ovws {

/// One run of a gain sweep on a bench.
struct ExperimentRun {
  std::string name;  ///< hash of request and bench, 16 hexadecimal digits
  GainSweep request;
  nlohmann::json bench;  ///< bench settings, see sweep_bench; must not change during the run
  std::int64_t t_begun_ns = 0;
  bool anew = false;  ///< delete earlier results and start over
};
/// Makes a run that begins now. Its name is a hash of the request and the bench.
ExperimentRun experiment_run(const GainSweepRun& asked, nlohmann::json bench);

/// Gain sweep archive with the most recently requested run in memory; earlier runs stay on disk.
/// Thread-safe.
class ExperimentArchive {
 public:
  static constexpr std::size_t kMaxRuns = 4;  ///< runs on disk; the oldest is deleted first
  using Stop = DaemonStore::Stop;

  explicit ExperimentArchive(DaemonStore& store) : store_(store) {}

  /// Loads the most recently requested run when the daemon starts. Blocks on the disk.
  void load();

  // The job's thread calls `open`, `put_reference` and `put_cell`, which block on the disk until
  // the job is stopped. If a file cannot be written, the sweep continues and `result` reports why.
  /// Opens the run that `begin_job` selected. Loads its earlier results, or deletes them if `anew`.
  /// Retries earlier failed writes. Errors: the earlier results cannot be loaded or deleted;
  /// Errc::unavailable, the job was stopped.
  Result<void> open(bool anew, const Stop& stop = {});
  void put_reference(int arm, nlohmann::json reference, const Stop& stop = {});
  void put_cell(int cell, nlohmann::json measured, const Stop& stop = {});
  nlohmann::json reference(int arm) const;  ///< null: not measured yet
  bool has_cell(int cell) const;

  /// Makes `run` the current run, measured by job `job`. Call this before the job's number is
  /// published. A run that was not current before, or that starts over (`anew`), has no cells until
  /// `open`. Never blocks on the disk.
  void begin_job(const ExperimentRun& run, int job);
  void end_job();
  /// Number of the job that is measuring the run; none if no job measures it.
  std::optional<int> job_of(const std::string& run) const;

  nlohmann::json result() const;  ///< result of experiment.get
  /// Passes the result of experiment.cell to `done`: at once, or in the disk thread if the cell's
  /// image must be read. Errc::invalid: no cell has this number. Errc::refused: the cell has not
  /// been measured yet. Errc::unavailable: too many requests are waiting for the disk.
  void cell(int number, std::function<void(Result<nlohmann::json>)> done);

 private:
  struct Job {
    std::string run;
    int number = 0;
    std::int64_t t_begun_mono_ns = 0;
    int done = 0;
  };
  Result<void> read(const ExperimentRun& run, const Stop& stop);
  Result<void> load_if_stored(ExperimentRun run, const Stop& stop);
  ExperimentRun current_run() const;
  /// Stores the reason of a failed write for `result`. Returns false if the write failed.
  bool remember_failure(const Result<void>& kept);
  std::optional<std::string> image_in_memory(const ExperimentRun& run, int cell) const;
  std::optional<std::string> why_not_kept() const;  // call with mutex_ locked
  std::optional<double> time_left_s() const;        // call with mutex_ locked

  DaemonStore& store_;
  mutable std::mutex mutex_;  ///< never held during disk access
  std::optional<ExperimentRun> run_;
  bool load_pending_ = false;  ///< the stored results have not been loaded yet
  std::vector<nlohmann::json> references_;
  std::vector<nlohmann::json> cells_;    ///< as in experiment.cell, without the images' pixels
  std::map<int, std::string> pictures_;  ///< base64 images that could not be stored, by cell number
  std::optional<Job> job_;
  std::optional<std::string> not_kept_reason_;  ///< why a write failed; none: no failure
};

}  // namespace ovws
