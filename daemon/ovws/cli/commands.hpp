/// The subcommands of ovws. Each add_… registers a command, whose callback sets the exit status.
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/shared/client.hpp"

namespace ovws::cli {

/// Help of --config for commands that work offline. They ignore saved settings, so that the same
/// file gives the same result on every machine.
inline constexpr const char* kConfigHelp =
    "the daemon's configuration file (default: every key's default); saved settings are ignored: "
    "ovwsd --check-config --config FILE > NEW prints a file that includes them";

/// Whether standard output is a pipe or terminal whose reader has gone.
bool output_has_no_reader();

/// Accepts a number from `min` to `max` and rejects NaN, which CLI::Range accepts.
CLI::Validator number_from(double min, double max);

// `common` and `status` must outlive the parsing: the callbacks hold references to them.
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
