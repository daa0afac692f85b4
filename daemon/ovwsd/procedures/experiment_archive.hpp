/// The gain sweeps of this bench: what was measured of them stays, cell by cell, until all of it is
/// there.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/procedures/experiment_files.hpp"

namespace ovws {

/// Holds one run, that was asked for last; those of before stay on the disk (ExperimentFiles).
/// Thread-safe.
class ExperimentArchive {
 public:
  explicit ExperimentArchive(DaemonStore& store) : files_(store) {}

  /// At the start: the run that was asked for last. Waits for the disk.
  void load();

  // The job's thread; they wait for the disk. What cannot be kept is measured all the same, and
  // `report` says why it is not kept.
  /// All that is known of the run of `begin_job`; nothing if `anew`. What the disk did not take of
  /// it before is offered again. Errors (Errc::unavailable): what was measured before cannot be
  /// removed.
  Result<void> open(bool anew);
  void put_reference(int arm, nlohmann::json reference);
  void put_cell(int cell, nlohmann::json measured);
  nlohmann::json reference(int arm) const;  ///< null: not measured yet
  bool has_cell(int cell) const;

  /// Before anybody is told of it: job `job` measures that run now. It is the run that is held from
  /// now on; one that was not, or is measured anew, has no cells before `open`. Never waits.
  void begin_job(const ExperimentRun& run, int job);
  void end_job();
  /// The job that measures it now.
  std::optional<int> job_of(const std::string& run) const;

  nlohmann::json result() const;  ///< of experiment.get
  /// Of experiment.cell; `done` at once, or in the disk thread if a picture belongs to it.
  /// Errc::invalid if there is no such cell, Errc::refused if it was not measured yet,
  /// Errc::unavailable if too many wait for the disk.
  void cell(int number, std::function<void(Result<nlohmann::json>)> done);

 private:
  struct Job {
    std::string run;
    int number = 0;
    std::int64_t t_begun_mono_ns = 0;
    int done = 0;
  };
  void read(const ExperimentRun& run);
  void read_if_known(ExperimentRun run);
  ExperimentRun held() const;
  /// False: the store has none of it, and why is remembered.
  bool note(const Result<void>& kept);
  std::optional<std::string> picture_in_memory(const ExperimentRun& run, int cell) const;
  std::optional<std::string> why_not_kept() const;  // call with mutex_ locked
  std::optional<double> time_left_s() const;        // call with mutex_ locked

  ExperimentFiles files_;
  mutable std::mutex mutex_;  ///< never held while the disk works
  std::optional<ExperimentRun> run_;
  bool to_read_ = false;  ///< what the store has of it is not in memory yet
  std::vector<nlohmann::json> references_;
  std::vector<nlohmann::json> cells_;    ///< as of experiment.cell, but the pictures' pixels
  std::map<int, std::string> pictures_;  ///< that the store does not hold, by cell
  std::optional<Job> job_;
  std::optional<std::string> not_kept_reason_;  ///< of what the store does not hold
};

}  // namespace ovws
