/// Access control by keys: CURVE on every socket, and a handler of ZeroMQ's authentication protocol
/// (ZAP, RFC 27) that checks the clients' public keys.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Callbacks of the gate, called in the ControlServer's thread unless stated otherwise.
struct GateCalls {
  std::function<bool(const std::string& public_key)> knows;
  /// A client was rejected; `why` is a message for the user.
  std::function<void(const std::string& why)> rejected;
  /// Called in the publisher's thread. An error means that rebinding has failed for 1 s and that
  /// the publisher sends nothing; success means that the publisher is bound again.
  std::function<void(const std::string& endpoint, const Result<void>& bound)> rebound;
};

/// Access gate: sockets bound with it accept only clients whose public keys `knows` accepts. The
/// gate must outlive its sockets, because without a ZAP handler libzmq accepts every key. The
/// gate's ControlServer runs the ZAP handler; until the server runs, no client is accepted.
class Gate {
 public:
  /// Makes a gate with the daemon's secret key. Errors: Errc::invalid, field "security.secret_key",
  /// for a malformed key.
  static Result<std::unique_ptr<Gate>> make(const std::string& secret_key, GateCalls calls);

  /// Disconnects all subscribers, so that each must authenticate again. Each publisher rebinds its
  /// socket before its next message and sends nothing more over old connections. Thread-safe.
  void end_streams();

  struct Parts;  ///< internal state, for this driver's sockets only
  Parts& parts() { return *parts_; }

 private:
  explicit Gate(Hidden<Parts> parts) : parts_(std::move(parts)) {}
  Hidden<Parts> parts_;
};

}  // namespace ovws
