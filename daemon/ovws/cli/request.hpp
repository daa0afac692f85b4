/// Requests of subcommands: calls, waits for jobs, and prints what came back.
#pragma once

#include <chrono>
#include <csignal>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/result.hpp"
#include "daemon/shared/job.hpp"

namespace ovws::cli {

/// From now on these signals do not end the process; `was_interrupted` reports them.
void catch_interrupts(std::initializer_list<int> signals = {SIGINT, SIGTERM, SIGHUP});
bool was_interrupted();

constexpr std::chrono::milliseconds kPollInterval{200};  ///< of what a command waits for

/// Calls a method. If it starts a job, waits for its end, and shows progress and time left on a
/// terminal (stderr). Ctrl-C cancels the job.
Answer call_and_wait(const Common& common, const std::string& method, const nlohmann::json& params);

/// The next wavefront message; null if none comes within a second.
Answer newest_wavefront(const Common& common);

/// Prints `text`, or with --json `result` on one line. With `indent`, wraps the text for the
/// terminal, and indents what follows in a line by so much. Returns kOk.
int print_result(const Common& common, const nlohmann::json& result, const std::string& text,
                 std::optional<std::size_t> indent = std::nullopt);
constexpr std::size_t kAnswerIndent = 2;

/// Prints a mistake of the command line on stderr (as JSON on stdout with --json). Returns kUsage.
int report_mistake(const Common& common, const Error& error);

}  // namespace ovws::cli
