/// `ovws study rejection`: what the closed loop of a daemon's bench takes away of what moves.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "daemon/ovws/cli/commands.hpp"

namespace ovws::cli {

/// Records the wavefront for so long with the loop open, closes it with these params of loop.close,
/// records as long again, and writes rejection-spectra, rejection and summary. However it ends, by
/// Ctrl-C too, the loop is then open and the correction as it was. An exit code.
int run_rejection(const Common& common, const nlohmann::json& params, double seconds,
                  const std::filesystem::path& folder);

}  // namespace ovws::cli
