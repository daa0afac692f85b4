/// The binary part of a `spots` message.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace ovws {

/// One spot, in the order of the subapertures. Camera pixels; NaN: lost, or without a reference.
struct SpotRow {
  float x = 0, y = 0, ref_x = 0, ref_y = 0;
  float peak = 0, quality = 0;
};

inline std::vector<SpotRow> spot_rows(std::span<const std::byte> binary) {
  std::vector<SpotRow> rows(binary.size() / sizeof(SpotRow));
  if (!rows.empty()) std::memcpy(rows.data(), binary.data(), rows.size() * sizeof(SpotRow));
  return rows;
}

}  // namespace ovws
