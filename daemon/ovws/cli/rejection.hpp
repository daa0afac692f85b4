/// `ovws study rejection`: measures the closed loop's disturbance rejection on a daemon's bench.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Records the wavefront for `seconds` with the loop open, closes the loop with these params of
/// loop.close, and records for `seconds` again. Writes rejection-spectra, rejection and summary. On
/// return, also after Ctrl-C, the loop is open and has its previous correction. Returns an exit
/// code.
int run_rejection(const Common& common, const nlohmann::json& params, double seconds,
                  const std::filesystem::path& folder);

}  // namespace ovws::cli
