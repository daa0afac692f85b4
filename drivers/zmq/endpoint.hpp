/// Binding and connecting ZeroMQ sockets with errors that a person understands. Private to this
/// driver; `socket` is a libzmq socket handle.
#pragma once

#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// The file of an ipc endpoint is for the process's user and group alone (mode 0660).
/// Errors: Errc::unavailable (in use, no such address, no permission), Errc::invalid (not
/// understood); both name the endpoint.
Result<void> bind_endpoint(void* socket, const std::string& endpoint);
/// Errors: Errc::invalid. That nobody answers there shows only later.
Result<void> connect_endpoint(void* socket, const std::string& endpoint);

}  // namespace ovws
