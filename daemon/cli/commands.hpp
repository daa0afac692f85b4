/// The subcommands of ovws: each adds itself to the command line and says how it ended.
#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "core/base/result.hpp"

namespace ovws::cli {

/// Of commands that work offline: what a bench measured and saved stays out of a computation that
/// should be the same everywhere.
inline constexpr const char* kConfigHelp =
    "the daemon's configuration file (default: every key's default); what config.save saved is not "
    "laid over it: ovwsd --check-config --config FILE > NEW prints a file that has both";

// Exit codes.
constexpr int kOk = 0;
constexpr int kError = 1;     ///< the daemon, or the work, answered with an error
constexpr int kUsage = 2;     ///< the command line is wrong
constexpr int kNoDaemon = 3;  ///< nobody answered in time

struct Common {
  std::string endpoint = "tcp://127.0.0.1:7702";
  std::string key_path;    ///< empty: without keys
  std::string server_key;  ///< empty: that of the key file
  bool json = false;
  double timeout_s = 3.0;
};

/// Prints on standard output. A failure stays in ferror(stdout); `main` makes an exit code of it.
template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  const std::string text = fmt::format(format, std::forward<Args>(args)...);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

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

/// Tells an error on stderr (as JSON on stdout with --json) and returns kError.
int report(const Common& common, const Error& error);

}  // namespace ovws::cli
