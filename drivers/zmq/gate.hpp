/// Who may connect, where keys are configured: CURVE on every socket, and the answers of ZeroMQ's
/// authentication protocol (ZAP, RFC 27) by the clients' public keys.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// Called in the thread that turns the ControlServer, but for what says otherwise.
struct GateCalls {
  std::function<bool(const std::string& public_key)> knows;
  /// Somebody was not let in; `why` is for a person.
  std::function<void(const std::string& why)> rejected;
  /// The publisher's thread: one has not come to be bound anew for a second, and sends nothing;
  /// and, without an error, it is bound again.
  std::function<void(const std::string& endpoint, const Result<void>& bound)> rebound;
};

/// Sockets bound with it let in nobody but clients with keys that `knows` takes. It outlives them:
/// where nobody answers ZAP, libzmq lets every key in.
/// The ControlServer bound with it does its work: until that turns, nobody is let in.
class Gate {
 public:
  /// Errors: Errc::invalid, field "security.secret_key".
  static Result<std::unique_ptr<Gate>> make(const std::string& secret_key, GateCalls calls);
  ~Gate();
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;

  /// Thread-safe. No publisher sends anything more over the connections that it has: each is bound
  /// anew with its next message, and subscribers have to show their keys again.
  void end_streams();

  struct Parts;  ///< of this driver's sockets
  Parts& parts() { return *parts_; }

 private:
  explicit Gate(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace ovws
