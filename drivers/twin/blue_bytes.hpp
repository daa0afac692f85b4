/// Blue channel of 32-bit pixels (SIMD with run-time dispatch).
#pragma once

#include <cstdint>

namespace ovws::twin {

/// blue[k] = low byte of pixels[k], for k = 0 .. count - 1.
void blue_bytes(const std::uint32_t* pixels, int count, std::uint8_t* blue);

}  // namespace ovws::twin
