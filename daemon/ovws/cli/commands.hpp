/// The subcommands of ovws: each adds itself to the command line and says how it ended.
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Of commands that work offline: what a bench measured and saved stays out of a computation that
/// should be the same everywhere.
inline constexpr const char* kConfigHelp =
    "the daemon's configuration file (default: every key's default); what config.save saved is not "
    "laid over it: ovwsd --check-config --config FILE > NEW prints a file that has both";

/// Whether standard output is a pipe or terminal that nobody reads any more.
bool output_has_no_reader();

/// A finite number from `min` to `max`: CLI::Range lets NaN pass.
CLI::Validator number_from(double min, double max);

// `common` and `status` outlive the parsing.
void add_status(CLI::App& app, const Common& common, int& status);
void add_describe(CLI::App& app, const Common& common, int& status);
void add_call(CLI::App& app, const Common& common, int& status);
void add_watch(CLI::App& app, const Common& common, int& status);
void add_metrics(CLI::App& app, const Common& common, int& status);
void add_snapshot(CLI::App& app, const Common& common, int& status);
void add_hologram(CLI::App& app, const Common& common, int& status);
void add_farfield(CLI::App& app, const Common& common, int& status);
void add_measure(CLI::App& app, const Common& common, int& status);
void add_keygen(CLI::App& app, const Common& common, int& status);
void add_doctor(CLI::App& app, const Common& common, int& status);
void add_replay(CLI::App& app, const Common& common, int& status);
void add_study(CLI::App& app, const Common& common, int& status);
void add_completion(CLI::App& app);

}  // namespace ovws::cli
