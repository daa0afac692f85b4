/// Requests of subcommands: calls, waits for jobs, and prints what came back.
#pragma once

#include <chrono>
#include <csignal>
#include <initializer_list>
#include <nlohmann/json.hpp>
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

/// Prints `text` wrapped for the terminal, or with --json `answer` on one line. Returns kOk.
int print_answer(const Common& common, const nlohmann::json& answer, const std::string& text);

/// Prints a mistake of the command line on stderr (as JSON on stdout with --json). Returns kUsage.
int report_mistake(const Common& common, const Error& error);

}  // namespace ovws::cli
