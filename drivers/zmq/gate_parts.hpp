/// Implementation of the access gate (CURVE and ZAP), for the sockets bound with a gate. Private to
/// this driver.
#pragma once

#include <atomic>
#include <memory>
#include <vector>
#include <zmq.hpp>

#include "drivers/zmq/gate.hpp"

namespace ovws {

struct Gate::Parts {
  /// ZeroMQ context of all sockets bound with the gate: a ZAP handler serves one context only.
  std::shared_ptr<zmq::context_t> context;
  std::string secret_key;
  GateCalls calls;
  zmq::socket_t zap;
  std::vector<zmq::socket_t> monitors;  ///< report handshakes that failed before ZAP
  std::atomic<unsigned> generation{0};  ///< counts end_streams; older publishers must rebind

  /// ZAP status code in the reply to a client with an unknown key.
  enum class UnknownKey {
    reject,  ///< 400: permanent error; the connection ends with a reason
    retry,   ///< 300: temporary error; the client retries. For subscribers, which never learn
             ///< the reason and whose key may be added later
  };
  /// Makes a socket encrypt, and admit only clients with a known key (CURVE, ZeroMQ's security).
  /// `unknown_key`: the reply to other clients. Call it before the socket is bound.
  void guard(zmq::socket_t& socket, UnknownKey unknown_key);
  /// Appends the sockets that `serve` reads to the poll list `items`.
  void add_to(std::vector<zmq_pollitem_t>& items);
  /// Answers waiting ZAP requests and reports failed handshakes; never blocks.
  void serve();

 private:
  bool answer_one();
  static bool note_one(zmq::socket_t& monitor, const GateCalls& calls);
};

/// The gate's ZeroMQ context, or a new context for a socket without a gate.
inline std::shared_ptr<zmq::context_t> context_of(Gate* gate) {
  return gate != nullptr ? gate->parts().context : std::make_shared<zmq::context_t>(1);
}

}  // namespace ovws
