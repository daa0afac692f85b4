/// Messages of the measurement stream that do not come from frames: the publish thread sends them.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <variant>

#include "proto/messages.hpp"

namespace ovws {

struct Event {
  EventMessage message;
  nlohmann::json data;
};

/// Thread-safe. The oldest messages go if nobody sends them; the publish thread numbers what it
/// sends.
class StreamQueue {
 public:
  using Message = std::variant<Event, StatusMessage, RefinedMessage>;

  void put(Message message) {
    const std::lock_guard lock(mutex_);
    if (messages_.size() >= kMostWaiting) messages_.pop_front();
    messages_.push_back(std::move(message));
  }

  std::optional<Message> take() {
    const std::lock_guard lock(mutex_);
    if (messages_.empty()) return std::nullopt;
    Message message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }

  /// Something changed that `status` tells: the status thread publishes it at once.
  void ask_for_status() { status_wanted_.store(true); }
  bool take_status_request() { return status_wanted_.exchange(false); }

 private:
  static constexpr std::size_t kMostWaiting = 256;
  std::mutex mutex_;
  std::deque<Message> messages_;
  std::atomic<bool> status_wanted_{false};
};

}  // namespace ovws
