#include "daemon/web/board.hpp"

#include <algorithm>
#include <utility>

namespace ovws::web {
namespace {

constexpr std::array<std::size_t, kSeries> kKept{kEventsKept, kTrendKept, kHistoryKept};

void append_length(std::string& bytes, std::size_t length) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes.push_back(char(std::uint8_t(std::uint32_t(length) >> shift)));
  }
}

}  // namespace

std::string framed(std::string_view text, std::span<const std::byte> binary) {
  std::string bytes;
  bytes.reserve(2 * sizeof(std::uint32_t) + text.size() + binary.size());
  append_length(bytes, text.size());
  append_length(bytes, binary.size());
  bytes.append(text);
  bytes.append(reinterpret_cast<const char*>(binary.data()), binary.size());
  return bytes;
}

void Board::put(Slot slot, std::string bytes) {
  const std::scoped_lock lock(mutex_);
  newest_[std::size_t(slot)] = std::make_shared<const Packet>(Packet{++version_, std::move(bytes)});
}

void Board::append(Series series, std::string bytes) {
  const std::scoped_lock lock(mutex_);
  auto& kept = series_[std::size_t(series)];
  kept.push_back(std::make_shared<const Packet>(Packet{++version_, std::move(bytes)}));
  if (kept.size() > kKept[std::size_t(series)]) kept.pop_front();
}

std::vector<PacketPtr> Board::newer(std::uint64_t& seen) const {
  std::vector<PacketPtr> found;
  const std::scoped_lock lock(mutex_);
  if (seen == version_) return found;
  for (const PacketPtr& packet : newest_) {
    if (packet && packet->version > seen) found.push_back(packet);
  }
  for (const auto& kept : series_) {
    for (auto packet = kept.rbegin(); packet != kept.rend() && (*packet)->version > seen;
         ++packet) {
      found.push_back(*packet);
    }
  }
  std::sort(found.begin(), found.end(),
            [](const PacketPtr& a, const PacketPtr& b) { return a->version < b->version; });
  seen = version_;
  return found;
}

}  // namespace ovws::web
