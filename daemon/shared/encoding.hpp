/// SHA-256 checksums as hexadecimal text, and base64 encoding of arrays for JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ovws {

/// SHA-256 checksum as 64 lower-case hexadecimal digits, as `sha256sum` prints it.
std::string sha256_hex(std::string_view bytes);

/// SHA-256 checksum of an array's bytes, in the form of sha256_hex.
template <class T>
std::string sha256_of(std::span<const T> values) {
  return sha256_hex({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

/// RFC 4648, with padding.
std::string base64_of(std::span<const std::uint8_t> bytes);
/// Decodes base64. None unless the text encodes exactly `count` bytes.
std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view base64, std::size_t count);

/// Encodes little-endian float32 as base64 (RFC 4648, with padding). All bits are kept, also of
/// NaN.
std::string base64_of(std::span<const float> values);
/// Decodes base64 of float32. None unless the text encodes exactly `count` float32.
std::optional<std::vector<float>> floats_of(std::string_view base64, std::size_t count);

}  // namespace ovws
