/// ZeroMQ endpoints as written in the configuration and on the command line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ovws {

/// HOST of "tcp://HOST:PORT"; empty for anything else.
std::string host_of(std::string_view endpoint);

/// Why a text is not a valid endpoint; none if it is valid. Valid are tcp://ADDRESS:PORT with a
/// port from 1 to 65535, and ipc://PATH with a path of at most 107 bytes. ADDRESS is a host name,
/// an interface, an IPv4 address or an IPv6 address in brackets. libzmq does not check the port: it
/// wraps 99999 to 34463.
std::optional<std::string> endpoint_fault(std::string_view endpoint);

/// Why a socket cannot be bound to an endpoint; none if it may be. Not valid are texts with an
/// endpoint_fault, and localhost: libzmq binds addresses and interfaces, and resolves no name.
std::optional<std::string> bind_fault(std::string_view endpoint);

/// Whether a valid endpoint is an IPv6 address, for which a ZeroMQ socket needs ZMQ_IPV6. With that
/// option libzmq resolves a name such as localhost to IPv6 only, so other endpoints go without it.
bool is_ipv6(std::string_view endpoint);

/// Whether an endpoint is reachable from this machine only: a numeric loopback address, or an ipc
/// path, which file permissions protect ("@name" has no file and does not count).
bool is_reached_from_here_only(std::string_view endpoint);

/// The endpoint by which a client on this machine reaches a bound `endpoint`: the loopback address
/// in place of `*`, 0.0.0.0 and [::]; any other endpoint unchanged.
std::string local_endpoint(std::string_view endpoint);

}  // namespace ovws
