/// Events: each goes to the log and to the `event` stream, and requests a status message.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "proto/messages.hpp"

namespace ovws {

class StreamQueue;

class Events {
 public:
  explicit Events(StreamQueue& queue) : queue_(queue) {}

  /// Thread-safe. `kind` as in the `event` message, `text` one sentence for a person, `data` fields
  /// for a program.
  void emit(std::string kind, Severity severity, std::string text,
            nlohmann::json data = nlohmann::json::object());

  /// Thread-safe: requests a status message at once, for a change that is no event.
  void status_changed();

 private:
  StreamQueue& queue_;
};

}  // namespace ovws
