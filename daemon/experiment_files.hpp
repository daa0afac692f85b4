/// The gain sweeps of this bench on the disk: a header a run, and files of its references, cells
/// and pictures.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/daemon_store.hpp"
#include "daemon/experiment_run.hpp"

namespace ovws {

/// Thread-safe; waits for the disk. Errors are those of DaemonStore.
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

  Result<void> put_header(const ExperimentRun& run);
  Result<void> put_reference(const ExperimentRun& run, int arm, nlohmann::json reference);
  Result<void> put_cell(const ExperimentRun& run, int cell, nlohmann::json measured);
  Result<void> put_picture(const ExperimentRun& run, int cell, const std::string& base64);

  /// Measured, and refused by the disk, by number.
  struct NotKept {
    std::map<int, nlohmann::json> references, cells;
    std::map<int, std::string> pictures;
  };
  /// Tries again; what the disk takes leaves `rest`. The error is that of the last one refused.
  Result<void> put(const ExperimentRun& run, NotKept& rest);
  /// What could not be kept of the run is lost, and is no longer told.
  void give_up(const ExperimentRun& run);

  /// All but the header.
  Result<void> drop_measured(const ExperimentRun& run);
  /// All but the latest kMostKept runs; `current` is one of these.
  void drop_oldest(const std::string& current);

 private:
  Result<void> put(const std::string& kind, const std::string& name, const nlohmann::json& content);

  DaemonStore& store_;
};

}  // namespace ovws
