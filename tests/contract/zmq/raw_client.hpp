/// Raw libzmq client, to send malformed messages.
#pragma once

#include <zmq.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ovws::test {

class RawClient {
 public:
  /// `receive_queue`: high-water mark of received messages; 0: the library's default.
  RawClient(int type, const std::string& endpoint, std::string_view routing_id = {},
            int receive_queue = 0)
      : context_(zmq_ctx_new()), socket_(zmq_socket(context_, type)) {
    const int none = 0;
    zmq_setsockopt(socket_, ZMQ_LINGER, &none, sizeof none);
    if (!routing_id.empty()) {
      zmq_setsockopt(socket_, ZMQ_ROUTING_ID, routing_id.data(), routing_id.size());
    }
    if (receive_queue > 0) {
      zmq_setsockopt(socket_, ZMQ_RCVHWM, &receive_queue, sizeof receive_queue);
    }
    zmq_connect(socket_, endpoint.c_str());
  }
  ~RawClient() {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  void send(const std::vector<std::string>& frames) {
    for (std::size_t k = 0; k < frames.size(); ++k) {
      zmq_send(socket_, frames[k].data(), frames[k].size(),
               k + 1 < frames.size() ? ZMQ_SNDMORE : 0);
    }
  }

  /// Frames of the next message; empty on time-out.
  std::vector<std::string> receive(int timeout_ms = 5000) {
    zmq_pollitem_t item{socket_, 0, ZMQ_POLLIN, 0};
    std::vector<std::string> frames;
    if (zmq_poll(&item, 1, timeout_ms) <= 0) return frames;
    int more = 1;
    while (more != 0) {
      zmq_msg_t part;
      zmq_msg_init(&part);
      zmq_msg_recv(&part, socket_, 0);
      frames.emplace_back(static_cast<char*>(zmq_msg_data(&part)), zmq_msg_size(&part));
      more = zmq_msg_more(&part);
      zmq_msg_close(&part);
    }
    return frames;
  }

  void* handle() { return socket_; }

 private:
  void* context_;
  void* socket_;
};

}  // namespace ovws::test
