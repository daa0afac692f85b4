#include "daemon/shared/encoding.hpp"

#include <sodium.h>

#include <array>
#include <bit>
#include <cstring>

namespace ovws {

static_assert(std::endian::native == std::endian::little, "float32 are kept as they lie in memory");

std::string sha256_hex(std::string_view bytes) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size());
  std::string hex(2 * hash.size() + 1, '\0');
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  hex.pop_back();
  return hex;
}

std::string base64_of(std::span<const std::uint8_t> bytes) {
  constexpr int kVariant = sodium_base64_VARIANT_ORIGINAL;
  std::string text(sodium_base64_encoded_len(bytes.size(), kVariant), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), kVariant);
  text.pop_back();
  return text;
}

std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view base64, std::size_t count) {
  if (base64.size() / 4 * 3 > count + 2) return std::nullopt;
  std::vector<std::uint8_t> bytes(count);
  std::size_t read = 0;
  const int failed = sodium_base642bin(bytes.data(), count, base64.data(), base64.size(), nullptr,
                                       &read, nullptr, sodium_base64_VARIANT_ORIGINAL);
  if (failed != 0 || read != count) return std::nullopt;
  return bytes;
}

std::string base64_of(std::span<const float> values) {
  return base64_of(
      std::span(reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()));
}

std::optional<std::vector<float>> floats_of(std::string_view base64, std::size_t count) {
  const auto bytes = bytes_of(base64, count * sizeof(float));
  if (!bytes) return std::nullopt;
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes->data(), bytes->size());
  return values;
}

}  // namespace ovws
