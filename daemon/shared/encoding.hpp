/// SHA-256 checksums as hexadecimal text, and base64 encoding of arrays for JSON.
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

/// SHA-256 of an array's bytes, as sha256_hex.
template <class T>
std::string sha256_of(std::span<const T> values) {
  return sha256_hex({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

/// RFC 4648, with padding.
std::string base64_of(std::span<const std::uint8_t> bytes);
/// None unless it is base64 of exactly `count` bytes.
std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view base64, std::size_t count);

/// Little-endian float32 as base64 (RFC 4648, with padding); keeps all bits, also of NaN.
std::string base64_of(std::span<const float> values);
/// None unless it is base64 of exactly `count` float32.
std::optional<std::vector<float>> floats_of(std::string_view base64, std::size_t count);

}  // namespace ovws
