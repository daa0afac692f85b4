/// Endpoints as they are written in the configuration and on the command line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ovws {

/// Why a text is not an endpoint; none if it is one: tcp://ADDRESS:PORT with a port from 1 to
/// 65535, or ipc://PATH of at most 107 bytes. (libzmq itself takes port 99999 for 34463.)
std::optional<std::string> endpoint_fault(std::string_view endpoint);

/// Whether nobody on another machine, and nobody who may not open the file of an ipc endpoint, can
/// reach it: a loopback address in numbers, or an ipc path (not "@name", which has no file).
bool is_reached_from_here_only(std::string_view endpoint);

/// Where a client on the same machine connects to what is bound to `endpoint`: the loopback address
/// in place of `*`, 0.0.0.0 and [::], any other endpoint as it is.
std::string local_endpoint(std::string_view endpoint);

}  // namespace ovws
