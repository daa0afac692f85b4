/// The gain sweeps of this bench on the disk: a header a run, and files of its references, cells
/// and pictures.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ovwsd/procedures/experiment_run.hpp"
#include "daemon/ovwsd/store/daemon_store.hpp"

namespace ovws {

/// Thread-safe; waits for the disk, but for what says otherwise. Errors are those of DaemonStore,
/// which tries again what could not be written.
class ExperimentFiles {
 public:
  static constexpr std::size_t kMostKept = 4;  ///< runs; that of longest ago goes first

  explicit ExperimentFiles(DaemonStore& store) : store_(store) {}

  /// The run that was opened last.
  std::optional<ExperimentRun> latest() const;
  /// The run of that name, with the request that it was opened with.
  std::optional<ExperimentRun> find(const std::string& name) const;

  struct Measured {
    std::vector<nlohmann::json> references;  ///< one an arm, null: none is kept
    std::vector<nlohmann::json> cells;       ///< the same, without the pictures' pixels
  };
  /// Of that very measuring of the run: not what an earlier one left behind.
  Measured measured(const ExperimentRun& run) const;
  std::optional<std::string> picture(const ExperimentRun& run, int cell) const;

  /// Errors: neither the disk nor the store's queue has it.
  Result<void> put_header(const ExperimentRun& run);
  Result<void> put_reference(const ExperimentRun& run, int arm, nlohmann::json reference);
  Result<void> put_cell(const ExperimentRun& run, int cell, nlohmann::json measured);
  Result<void> put_picture(const ExperimentRun& run, int cell, const std::string& base64);

  /// What could not be written before is tried once more.
  void try_again() { store_.try_again_and_wait(); }
  /// Never waits: why something of the run is not on the disk.
  std::optional<std::string> why_not_kept(const ExperimentRun& run) const;
  /// Never waits: `then` in the disk thread, with the picture. Errors as of Disk::request.
  Result<void> request_picture(const ExperimentRun& run, int cell,
                               std::function<void(std::optional<std::string>)> then);

  /// All but the header.
  Result<void> drop_measured(const ExperimentRun& run);
  /// All but the latest kMostKept runs; `current` is one of these.
  void drop_oldest(const std::string& current);

 private:
  Result<void> put(const std::string& kind, const std::string& name, const nlohmann::json& content);

  DaemonStore& store_;
};

}  // namespace ovws
