/// Binds and connects ZeroMQ sockets with user-friendly errors. Private to this driver; `socket` is
/// a libzmq socket handle.
#pragma once

#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// Binds a socket. The file of an ipc endpoint gets mode 0660. Errors: Errc::unavailable (address
/// in use, no such address, no permission), Errc::invalid (malformed endpoint). Both errors name
/// the endpoint.
Result<void> bind_endpoint(void* socket, const std::string& endpoint);
/// Connects a socket. Errors: Errc::invalid (malformed). Succeeds even if no peer listens, because
/// libzmq connects in the background.
Result<void> connect_endpoint(void* socket, const std::string& endpoint);

}  // namespace ovws
