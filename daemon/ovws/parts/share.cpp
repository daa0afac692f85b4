#include "daemon/ovws/parts/share.hpp"

#include <spdlog/fmt/fmt.h>

#include <charconv>
#include <optional>
#include <utility>

namespace ovws {
namespace {

constexpr std::uint64_t kMaxShards = 100'000;

/// Two whole numbers with `between` between them.
std::optional<std::pair<std::uint64_t, std::uint64_t>> numbers(const std::string& text,
                                                               char between) {
  std::pair<std::uint64_t, std::uint64_t> read;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, read.first);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != between) return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, read.second);
  if (second.ec != std::errc() || second.ptr != end) return std::nullopt;
  return read;
}

}  // namespace

Result<Positions> parse_range(const std::string& text) {
  const auto read = numbers(text, ':');
  if (read && read->first <= read->second) return Positions{read->first, read->second};
  return fail(Errc::invalid, "frames",
              text + " is not A:B, the positions A to B-1 in the recording, counted from 0");
}

std::string text_of(const Positions& range) {
  return fmt::format("{}:{}", range.begin, range.end);
}

Result<Shard> parse_shard(const std::string& text) {
  const auto read = numbers(text, '/');
  if (read && read->first >= 1 && read->first <= read->second && read->second <= kMaxShards) {
    return Shard{int(read->first), int(read->second)};
  }
  return fail(Errc::invalid, "shard",
              fmt::format("{} is not i/N, with i from 1 to N and N up to {}", text, kMaxShards));
}

std::string text_of(const Shard& shard) {
  return fmt::format("{}/{}", shard.number, shard.of);
}

Positions consecutive(const Shard& shard, std::uint64_t items) {
  const auto begin_of = [&](int number) {
    const std::uint64_t n = std::uint64_t(number), of = std::uint64_t(shard.of);
    return items / of * n + items % of * n / of;
  };
  return {begin_of(shard.number - 1), begin_of(shard.number)};
}

}  // namespace ovws
