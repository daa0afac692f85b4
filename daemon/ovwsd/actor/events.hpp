/// What happened, told once: to the log, to the `event` stream, and to who waits for a change of
/// status.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "proto/messages.hpp"

namespace ovws {

class Events {
 public:
  explicit Events(StreamQueue& queue) : queue_(queue) {}

  /// Thread-safe. `kind` as in the `event` message, `text` one sentence for a person, `data` for a
  /// program.
  void emit(std::string kind, Severity severity, std::string text,
            nlohmann::json data = nlohmann::json::object());

  /// Thread-safe: what `status` tells has changed, without being an event; it is published at once.
  void status_changed() { queue_.ask_for_status(); }

 private:
  StreamQueue& queue_;
};

}  // namespace ovws
