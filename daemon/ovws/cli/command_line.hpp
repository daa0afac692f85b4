/// Command line of ovws: registers the subcommands and their options with CLI11. Only files that
/// need CLI11 include this header, because CLI11 takes seconds to compile.
#pragma once

#include "daemon/shared/client.hpp"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace ovws::cli {

/// Accepts a number from `min` to `max` and rejects NaN, which CLI::Range accepts.
CLI::Validator number_from(double min, double max);

// The callback of each command writes the exit code to `status`. `common` and `status` must outlive
// the parsing, because the callbacks hold references to them.
void add_online_commands(CLI::App& app, const Common& common, int& status);
void add_check(CLI::App& app, const Common& common, int& status);
void add_verbs(CLI::App& app, const Common& common, int& status);
void add_setup(CLI::App& app, const Common& common, int& status);
void add_offline_commands(CLI::App& app, const Common& common, int& status);
void add_export(CLI::App& app, const Common& common, int& status);

/// Prints a bash completion script. The script's tables come from the commands and options of `app`
/// and from the schemas of the daemon's methods.
void add_completion(CLI::App& app);

}  // namespace ovws::cli
