/// Channels and bits of 32-bit pixels as bytes (SIMD with run-time dispatch).
#pragma once

#include <cstdint>

namespace ovws::twin {

/// blue[k] = low byte of pixels[k], for k = 0 .. count - 1.
void blue_bytes(const std::uint32_t* pixels, int count, std::uint8_t* blue);

/// bytes[k] = 255 if bit number `bit` of pixels[k] is set, else 0, for k = 0 .. count - 1.
void bit_bytes(const std::uint32_t* pixels, int count, int bit, std::uint8_t* bytes);

}  // namespace ovws::twin
