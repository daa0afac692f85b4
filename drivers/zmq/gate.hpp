/// Access control by keys: CURVE on every socket, and a handler of ZeroMQ's authentication protocol
/// (ZAP, RFC 27) that checks the clients' public keys.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Callbacks, in the thread of the ControlServer unless stated otherwise.
struct GateCalls {
  std::function<bool(const std::string& public_key)> knows;
  /// A client was rejected; `why` is a message for the user.
  std::function<void(const std::string& why)> rejected;
  /// In the publisher's thread. With an error: rebinding has failed for a second, and the publisher
  /// sends nothing. Without: it is bound again.
  std::function<void(const std::string& endpoint, const Result<void>& bound)> rebound;
};

/// Sockets bound with a gate accept only clients whose keys `knows` accepts. The gate must outlive
/// them: without a ZAP handler libzmq accepts every key. The ControlServer bound with it runs the
/// handler; until that runs, no client is accepted.
class Gate {
 public:
  /// Errors: Errc::invalid, field "security.secret_key", for a malformed key.
  static Result<std::unique_ptr<Gate>> make(const std::string& secret_key, GateCalls calls);

  /// Disconnects all subscribers, who must authenticate again. Each publisher rebinds before its
  /// next message and sends nothing more over its old connections. Thread-safe.
  void end_streams();

  struct Parts;  ///< for this driver's sockets
  Parts& parts() { return *parts_; }

 private:
  explicit Gate(Hidden<Parts> parts) : parts_(std::move(parts)) {}
  Hidden<Parts> parts_;
};

}  // namespace ovws
