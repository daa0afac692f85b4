/// `ovws study experiment`: the paper's gain sweep experiment on a daemon's bench.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Starts experiment.gain_sweep with these params, or joins a running one. Writes each cell as soon
/// as it is measured, and table, figures and summary at the end. The first cell replaces the
/// study's earlier files in the folder. Ctrl-C cancels the job, an error here does not; the same
/// call continues the sweep. Returns an exit code.
int run_experiment(const Common& common, const nlohmann::json& params,
                   const std::filesystem::path& folder);

}  // namespace ovws::cli
