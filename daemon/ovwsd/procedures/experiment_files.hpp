/// Files of gain sweeps: for each run one header, and one file for each reference, cell and image.
#pragma once

#include <cstdint>
#include <functional>
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
/// A run that begins now.
ExperimentRun experiment_run(const GainSweepRun& asked, nlohmann::json bench);

/// Thread-safe. Waits for the disk unless stated otherwise. Errors are those of DaemonStore, which
/// retries failed writes.
class ExperimentFiles {
 public:
  static constexpr std::size_t kMaxRuns = 4;  ///< runs; the oldest is deleted first

  explicit ExperimentFiles(DaemonStore& store) : store_(store) {}

  /// The run that was opened most recently.
  std::optional<ExperimentRun> latest() const;
  /// The run of that name, with the request that it was opened with.
  std::optional<ExperimentRun> find(const std::string& name) const;

  struct Measured {
    std::vector<nlohmann::json> references;  ///< one for each arm; null: none is stored
    std::vector<nlohmann::json> cells;       ///< the same for cells, without the images' pixels
  };
  /// Results of this execution of the run, identified by t_begun_ns. Ignores leftovers of earlier
  /// ones.
  Measured measured(const ExperimentRun& run) const;

  enum class Part { reference, cell, picture };  ///< numbered by arm or by cell
  /// Errors: the file was neither written nor queued for writing.
  Result<void> put_header(const ExperimentRun& run);
  Result<void> put(const ExperimentRun& run, Part part, int number, nlohmann::json content);

  /// Retries failed writes once.
  void try_again() { store_.try_again_and_wait(); }
  /// Never waits: why a file of the run is not on disk; none: all are.
  std::optional<std::string> why_not_kept(const ExperimentRun& run) const;
  /// Never waits: calls `then` in the disk thread with the image. Errors: those of Disk::request.
  Result<void> request_picture(const ExperimentRun& run, int cell,
                               std::function<void(std::optional<std::string>)> then);

  /// Deletes all files of the run but the header.
  Result<void> drop_measured(const ExperimentRun& run);
  /// Deletes all but the latest kMaxRuns runs. Always keeps `current`.
  void drop_oldest(const std::string& current);

 private:
  Result<void> put_file(const std::string& kind, const std::string& name,
                        const nlohmann::json& content);

  DaemonStore& store_;
};

}  // namespace ovws
