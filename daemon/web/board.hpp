/// Latest-value buffer: the newest message of each kind, and a short history of events and trends,
/// for any number of browsers. Slow readers block nobody; they skip messages that were replaced.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ovws::web {

/// Message kinds of which only the newest message is kept.
enum class Slot { status, bench, health, wavefront, refined, spots, image };
constexpr std::size_t kSlots = 7;

/// Message kinds with a history: the last kEventsKept, kTrendKept and kHistoryKept messages.
enum class Series { event, trend, history };
constexpr std::size_t kSeries = 3;
constexpr std::size_t kEventsKept = 100;
constexpr std::size_t kTrendKept = 360;    ///< three minutes at two per second
constexpr std::size_t kHistoryKept = 720;  ///< an hour at one in five seconds

/// Frames a message for the browser: lengths of the JSON and of the binary part as two
/// little-endian uint32, then both parts.
std::string framed(std::string_view json, std::span<const std::byte> binary = {});

struct Packet {
  std::uint64_t version = 0;
  std::string bytes;
};
using PacketPtr = std::shared_ptr<const Packet>;

/// Buffer of messages for the browsers. Thread-safe.
class Board {
 public:
  void put(Slot slot, std::string bytes);
  void append(Series series, std::string bytes);

  /// Returns all messages newer than version `seen`, oldest first, and advances `seen`. Begin with
  /// 0 for all messages.
  std::vector<PacketPtr> newer(std::uint64_t& seen) const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t version_ = 0;
  std::array<PacketPtr, kSlots> newest_;
  std::array<std::deque<PacketPtr>, kSeries> series_;
};

}  // namespace ovws::web
