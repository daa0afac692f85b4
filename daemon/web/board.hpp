/// The newest message of each kind for any number of browsers, and the last of those that tell a
/// history. Nobody waits for a slow reader: what was replaced meanwhile it never sees.
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

/// Of each only the newest is kept.
enum class Slot { status, bench, health, wavefront, refined, spots, image, phase };
constexpr std::size_t kSlots = 8;

/// Of each the last ones are kept: kEventsKept and kTrendKept.
enum class Series { event, trend };
constexpr std::size_t kSeries = 2;
constexpr std::size_t kEventsKept = 100;
constexpr std::size_t kTrendKept = 360;  ///< at two a second: three minutes

/// One message as it goes to a browser: its JSON's length and its binary part's as two
/// little-endian uint32, then both.
std::string framed(std::string_view json, std::span<const std::byte> binary = {});

struct Packet {
  std::uint64_t version = 0;
  std::string bytes;
};
using PacketPtr = std::shared_ptr<const Packet>;

/// Thread-safe.
class Board {
 public:
  void put(Slot slot, std::string bytes);
  void append(Series series, std::string bytes);

  /// All that is newer than `seen`, the oldest first, and moves `seen` on. 0: all there is.
  std::vector<PacketPtr> newer(std::uint64_t& seen) const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t version_ = 0;
  std::array<PacketPtr, kSlots> newest_;
  std::array<std::deque<PacketPtr>, kSeries> series_;
};

}  // namespace ovws::web
