/// The gain sweeps of this bench: what was measured of them stays, cell by cell, until all of it is
/// there.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/daemon_store.hpp"
#include "proto/experiment.hpp"

namespace ovws {

/// A sweep on a bench.
struct ExperimentRun {
  std::string name;  ///< 16 hexadecimal digits: the same for the same sweep on the same bench
  GainSweep request;
  nlohmann::json bench;  ///< what its numbers are of, and the same while it lasts
  std::int64_t t_begun_ns = 0;
};
ExperimentRun experiment_run(const GainSweep& request, nlohmann::json bench);

/// Holds one run, that was asked for last; those of before stay on the disk. Thread-safe.
class ExperimentArchive {
 public:
  static constexpr std::size_t kMostKept = 4;  ///< runs on the disk; that of longest ago goes
                                               ///< first, never that which is open

  explicit ExperimentArchive(DaemonStore& store) : store_(store) {}

  /// At the start: the run that was asked for last. Waits for the disk.
  void load();

  // The job's thread; they wait for the disk. What cannot be kept is measured all the same, and
  // `report` says why it is not kept.
  /// All that is known of the run of `begin_job`; nothing if `anew`. Errors (Errc::unavailable):
  /// what was measured before cannot be removed.
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
  /// Of experiment.cell; waits for the disk if a picture belongs to it. Errc::invalid if there is
  /// no such cell, Errc::refused if it was not measured yet.
  Result<nlohmann::json> cell(int number) const;

 private:
  struct Job {
    std::string run;
    int number = 0;
    std::int64_t t_begun_mono_ns = 0;
    int done = 0;
  };
  void read(const ExperimentRun& run);
  void read_if_known(ExperimentRun run);
  Result<void> drop_measured(const ExperimentRun& run);
  void drop_oldest(const std::string& current);
  /// False: it could not be kept.
  bool put(const std::string& kind, const std::string& name, const nlohmann::json& content);
  void put_picture(const ExperimentRun& run, int cell, std::string base64);
  std::optional<std::string> picture_of(const ExperimentRun& run, int cell) const;
  std::optional<double> time_left_s() const;  // call with mutex_ locked

  DaemonStore& store_;
  mutable std::mutex mutex_;  ///< never held while the disk works
  std::optional<ExperimentRun> run_;
  bool to_read_ = false;  ///< what the store has of it is not in memory yet
  std::vector<nlohmann::json> references_;
  std::vector<nlohmann::json> cells_;  ///< as of experiment.cell, but the pictures' pixels
  /// Pixels that the store could not keep, by the cell's number.
  std::map<int, std::string> pictures_not_kept_;
  std::optional<Job> job_;
  std::optional<std::string> not_kept_reason_;
};

}  // namespace ovws
