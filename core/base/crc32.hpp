/// CRC-32 as zlib, PNG and Ethernet have it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace ovws {

/// Polynomial 0xedb88320 (reflected), begun and ended with all ones: zlib's crc32(0, bytes).
inline std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  static constexpr auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t k = 0; k < 256; ++k) {
      std::uint32_t value = k;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0 ? 0xedb88320U ^ (value >> 1U) : value >> 1U;
      }
      table[k] = value;
    }
    return table;
  }();
  std::uint32_t crc = 0xffffffffU;
  for (const std::uint8_t byte : bytes) crc = kTable[(crc ^ byte) & 0xffU] ^ (crc >> 8U);
  return ~crc;
}

}  // namespace ovws
