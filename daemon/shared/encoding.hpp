/// Bytes as text: checksums, and arrays of numbers for JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ovws {

/// 64 lower-case hexadecimal digits, as `sha256sum` prints them.
std::string sha256_hex(std::string_view bytes);

/// The same of an array's memory.
template <class T>
std::string sha256_of(std::span<const T> values) {
  return sha256_hex({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

/// RFC 4648, with padding.
std::string base64_of(std::span<const std::uint8_t> bytes);
/// None unless it is base64 of exactly `count` bytes.
std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view base64, std::size_t count);

/// Little-endian float32 as base64 (RFC 4648, with padding); NaN and all keep their bits.
std::string base64_of(std::span<const float> values);
/// None unless it is base64 of exactly `count` float32.
std::optional<std::vector<float>> floats_of(std::string_view base64, std::size_t count);

}  // namespace ovws
