/// Commands of a browser: which methods it may call, and the call.
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

/// {"method": ..., "params": {...}}, strict JSON. Refusal::malformed if it is not;
/// Refusal::command for a method that the page does not need.
tl::expected<Command, Refusal> parse_command(const std::string& body);

/// Waits for the daemon. {"result": ...} or {"error": {"code", "message", "data"}} as the daemon
/// said it; without an answer an error without a code.
std::string carry_out(const cli::Common& common, const Command& command);

}  // namespace ovws::web
