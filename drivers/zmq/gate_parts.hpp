/// What a gate is made of, for the sockets that stand behind it. Private to this driver.
#pragma once

#include <atomic>
#include <memory>
#include <vector>
#include <zmq.hpp>

#include "drivers/zmq/gate.hpp"

namespace ovws {

struct Gate::Parts {
  /// ZAP works within one context: sockets behind one gate share it.
  std::shared_ptr<zmq::context_t> context;
  std::string secret_key;
  GateCalls calls;
  zmq::socket_t zap;
  std::vector<zmq::socket_t> monitors;  ///< tell of handshakes that never came to ZAP
  std::atomic<unsigned> generation{0};  ///< a publisher's connections are of one generation

  /// What a client whose key is not known does then, by ZAP's status code.
  enum class Stranger {
    ends,         ///< 400: its connection ends for good, with a reason
    comes_again,  ///< 300: a subscriber is never told why nothing comes, so its key may be given
                  ///< back
  };
  /// Before the socket is bound.
  void guard(zmq::socket_t& socket, Stranger stranger);
  /// Appends what `serve` waits for.
  void add_to(std::vector<zmq_pollitem_t>& items);
  /// Answers and counts what is there; never waits.
  void serve();

 private:
  bool answer_one();
  static bool note_one(zmq::socket_t& monitor, const GateCalls& calls);
};

/// The gate's context, or one of its own for a socket without a gate.
inline std::shared_ptr<zmq::context_t> context_of(Gate* gate) {
  return gate != nullptr ? gate->parts().context : std::make_shared<zmq::context_t>(1);
}

}  // namespace ovws
