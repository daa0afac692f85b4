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

  /// Emits an event with the fields of the `event` message: `text` is one sentence for a person,
  /// `data` has fields for a program. Thread-safe.
  void emit(std::string kind, Severity severity, std::string text,
            nlohmann::json data = nlohmann::json::object());

  /// Requests a status message at once, for a change without an event. Thread-safe.
  void status_changed();

 private:
  StreamQueue& queue_;
};

}  // namespace ovws
