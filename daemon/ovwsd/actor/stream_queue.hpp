/// Queue of the measurement stream's messages that do not come from frames: event, status, refined.
/// The publish thread sends them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include "proto/messages.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// Bounded queue, thread-safe. Numbers the messages of each topic (`seq`) in order of arrival. When
/// the queue is full, the oldest message is dropped and counted; receivers see a gap in `seq`. The
/// thread that takes messages never waits for those that put them, which have a lower priority.
class StreamQueue {
 public:
  using Message = std::variant<EventMessage, StatusMessage, RefinedMessage>;

  void put(Message message) {
    const std::lock_guard lock(mutex_);
    number(message);
    if (messages_.size() >= kMaxQueued) {
      messages_.pop_front();
      ++dropped_;
    }
    messages_.push_back(std::move(message));
  }

  /// The oldest message; none if there is none, or while another thread puts one.
  std::optional<Message> take() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || messages_.empty()) return std::nullopt;
    Message message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }

  /// Waits for threads that put a message.
  bool is_empty() const {
    const std::lock_guard lock(mutex_);
    return messages_.empty();
  }

  /// Returns the number of messages dropped since the last call, and resets the count.
  std::uint64_t take_dropped() { return dropped_.exchange(0); }

  /// Requests a status message: the status thread publishes it at once.
  void request_status() { status_requested_.store(true); }
  bool take_status_request() { return status_requested_.exchange(false); }

 private:
  static constexpr std::size_t kMaxQueued = 256;

  void number(Message& message) {
    const std::uint64_t seq = next_seq_[message.index()]++;
    std::visit([seq](auto& one) { one.seq = seq; }, message);
  }

  mutable std::mutex mutex_;
  std::deque<Message> messages_;
  std::array<std::uint64_t, std::variant_size_v<Message>> next_seq_{};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<bool> status_requested_{false};
};

}  // namespace ovws
