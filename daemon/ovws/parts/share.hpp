/// Which items of a whole one part has: shard i of N, or a range of positions.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

/// Positions from `begin` to `end` - 1, counted from 0.
struct Positions {
  std::uint64_t begin = 0, end = 0;
  friend bool operator==(const Positions&, const Positions&) = default;
};

/// Reads "A:B". Errc::invalid, field "frames": no such text, or A is above B.
Result<Positions> parse_range(const std::string& text);
std::string text_of(const Positions& range);

/// Shard `number` of `of`, counted from 1.
struct Shard {
  int number = 1, of = 1;
  friend bool operator==(const Shard&, const Shard&) = default;
};

/// Reads "i/N". Errc::invalid, field "shard": no such text, i is not 1 to N, or N is above 100000.
Result<Shard> parse_shard(const std::string& text);
std::string text_of(const Shard& shard);

/// The shard's consecutive positions of `items`; all shards together have each position once, and
/// as many positions each as possible. For items that cost the same, and are stored one after
/// another.
Positions consecutive(const Shard& shard, std::uint64_t items);

}  // namespace ovws
