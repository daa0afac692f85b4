/// Command line of ovws: how a command is described to CLI11. The file of a command holds its
/// options, their help and what it does.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "daemon/ovws/parts/share.hpp"
#include "daemon/shared/job.hpp"
#include "proto/limits.hpp"

namespace ovws::cli {

/// Accepts a number from `min` to `max` and rejects NaN, which CLI::Range accepts.
CLI::Validator number_from(double min, double max);
inline CLI::Validator number_from(limits::Numbers range) {
  return number_from(range.min, range.max);
}

/// Help of --config. Saved settings are ignored, so that the same file gives the same result on
/// every machine.
inline constexpr const char* kConfigHelp =
    "the daemon's configuration file (default: every key's default); saved settings are ignored: "
    "ovwsd --check-config --config FILE > NEW prints a file that includes them";

struct NoOptions {};

template <class Options>
struct Command {
  CLI::App& syntax;
  Options& options;  ///< filled in by the parsing
};

/// Adds a command, which calls `run` with its options after the parsing and writes the exit code to
/// `status`. `run` may throw CallFailed, which is reported. `common` and `status` must outlive the
/// parsing.
template <class Options>
Command<Options> add_command(CLI::App& app, const Common& common, int& status, const char* name,
                             const char* help, int (*run)(const Common&, const Options&)) {
  CLI::App& syntax = *app.add_subcommand(name, help);
  auto options = std::make_shared<Options>();
  syntax.callback([&common, &status, options, run] {
    try {
      status = run(common, *options);
    } catch (const CallFailed& failed) {
      status = report_failure(common, failed.why);
    }
  });
  return {syntax, *options};
}

/// Why a text was refused; empty: it was not.
template <class T>
std::string why_refused(const Result<T>& read) {
  return read ? std::string() : read.error().reason;
}

/// Adds the option --shard.
inline CLI::Option* add_shard(CLI::App& command, std::optional<Shard>& shard,
                              const std::string& help) {
  return command
      .add_option_function<std::string>(
          "--shard", [&shard](const std::string& text) { shard = *parse_shard(text); }, help)
      ->type_name("i/N")
      ->check([](const std::string& text) { return why_refused(parse_shard(text)); });
}

// The commands, in the order of their help.
void add_verbs(CLI::App& app, const Common& common, int& status);
void add_online_commands(CLI::App& app, const Common& common, int& status);
void add_call(CLI::App& app, const Common& common, int& status);
void add_watch(CLI::App& app, const Common& common, int& status);
void add_metrics(CLI::App& app, const Common& common, int& status);
void add_snapshot(CLI::App& app, const Common& common, int& status);
void add_doctor(CLI::App& app, const Common& common, int& status);
void add_check(CLI::App& app, const Common& common, int& status);
void add_setup(CLI::App& app, const Common& common, int& status);
void add_design(CLI::App& app, const Common& common, int& status);
void add_advise(CLI::App& app, const Common& common, int& status);
void add_pictures(CLI::App& app, const Common& common, int& status);
void add_measure(CLI::App& app, const Common& common, int& status);
void add_keygen(CLI::App& app, const Common& common, int& status);
void add_replay(CLI::App& app, const Common& common, int& status);
void add_export(CLI::App& app, const Common& common, int& status);
void add_study(CLI::App& app, const Common& common, int& status);
void add_merge(CLI::App& app, const Common& common, int& status);

/// Prints a bash completion script. The script's tables come from the commands and options of `app`
/// and from the schemas of the daemon's methods.
void add_completion(CLI::App& app);

}  // namespace ovws::cli
