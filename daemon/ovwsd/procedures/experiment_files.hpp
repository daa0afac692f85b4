/// Files of gain sweeps: for each run one header, and one file for each reference, cell and image.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/procedures/experiment_run.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

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
  std::optional<std::string> picture(const ExperimentRun& run, int cell) const;

  /// Errors: the file was neither written nor queued for writing.
  Result<void> put_header(const ExperimentRun& run);
  Result<void> put_reference(const ExperimentRun& run, int arm, nlohmann::json reference);
  Result<void> put_cell(const ExperimentRun& run, int cell, nlohmann::json measured);
  Result<void> put_picture(const ExperimentRun& run, int cell, const std::string& base64);

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
  Result<void> put(const std::string& kind, const std::string& name, const nlohmann::json& content);

  DaemonStore& store_;
};

}  // namespace ovws
