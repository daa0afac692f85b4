/// Callback that sends the reply to one request.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace ovws {

/// Sends the reply's frame and the binary frame that follows it (null: none). Thread-safe; only the
/// first call sends. The binary frame is released when it was written to the connection.
using SendReply = std::function<void(std::string bytes, std::shared_ptr<const std::string> binary)>;

}  // namespace ovws
