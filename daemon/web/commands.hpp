/// Commands of a browser: allowed methods, and calls to the daemon.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/shared/client.hpp"
#include "daemon/web/access.hpp"

namespace ovws::web {

struct Command {
  std::string method;
  nlohmann::json params;
};

/// Parses {"method": ..., "params": {...}} as strict JSON. Errors: Refusal::malformed;
/// Refusal::command for a method that the page may not call.
tl::expected<Command, Refusal> parse_command(const std::string& body);

/// Whether the command may change what the page shows; false for those that only read.
bool changes_bench(const Command& command);

/// Calls the daemon and blocks for its reply. Returns {"result": ...} or {"error": {"code",
/// "message", "data"}} as text; if the daemon does not answer, the error has no code.
std::string carry_out(const cli::Common& common, const Command& command);

}  // namespace ovws::web
