/// Implementation of the gate, for the sockets behind it. Private to this driver.
#pragma once

#include <atomic>
#include <memory>
#include <vector>
#include <zmq.hpp>

#include "drivers/zmq/gate.hpp"

namespace ovws {

struct Gate::Parts {
  /// ZAP works within one context, so all sockets behind a gate share it.
  std::shared_ptr<zmq::context_t> context;
  std::string secret_key;
  GateCalls calls;
  zmq::socket_t zap;
  std::vector<zmq::socket_t> monitors;  ///< report handshakes that never reached ZAP
  std::atomic<unsigned> generation{0};  ///< a publisher of an older generation must rebind

  /// Reply to a client with an unknown key, as ZAP status code.
  enum class UnknownKey {
    reject,  ///< 400: permanent error; the connection ends with a reason
    retry,   ///< 300: temporary error; the client retries, because a subscriber never learns
             ///< the reason and its key may be restored
  };
  /// Protects a socket with CURVE. Call it before the socket is bound.
  void guard(zmq::socket_t& socket, UnknownKey unknown_key);
  /// Appends the sockets to poll for `serve`.
  void add_to(std::vector<zmq_pollitem_t>& items);
  /// Answers waiting ZAP requests and reports failed handshakes; never blocks.
  void serve();

 private:
  bool answer_one();
  static bool note_one(zmq::socket_t& monitor, const GateCalls& calls);
};

/// The gate's context, or a new one for a socket without a gate.
inline std::shared_ptr<zmq::context_t> context_of(Gate* gate) {
  return gate != nullptr ? gate->parts().context : std::make_shared<zmq::context_t>(1);
}

}  // namespace ovws
