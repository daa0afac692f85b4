/// `ovws study experiment`: the paper's experiment on a daemon's bench.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Asks the daemon for experiment.gain_sweep with these params, joins it if it runs, writes each
/// cell when it is there, and at the end table, figures and summary. The first cell takes the place
/// of what the study left in the folder before. Ctrl-C cancels the job, an error of ours does not;
/// asked again, it goes on. An exit code.
int run_experiment(const Common& common, const nlohmann::json& params,
                   const std::filesystem::path& folder);

}  // namespace ovws::cli
