#include "daemon/store/encoding.hpp"

#include <sodium.h>

#include <array>
#include <bit>

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

std::string base64_of(std::span<const float> values) {
  constexpr int kVariant = sodium_base64_VARIANT_ORIGINAL;
  std::string text(sodium_base64_encoded_len(values.size_bytes(), kVariant), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(values.data()),
                    values.size_bytes(), kVariant);
  text.pop_back();
  return text;
}

std::optional<std::vector<float>> floats_of(std::string_view base64, std::size_t count) {
  if (base64.size() / 4 * 3 > count * sizeof(float) + 2) return std::nullopt;
  std::vector<float> values(base64.size() / 4 * 3 / sizeof(float));
  std::size_t bytes = 0;
  const int read = sodium_base642bin(reinterpret_cast<unsigned char*>(values.data()),
                                     values.size() * sizeof(float), base64.data(), base64.size(),
                                     nullptr, &bytes, nullptr, sodium_base64_VARIANT_ORIGINAL);
  if (read != 0 || bytes != count * sizeof(float)) return std::nullopt;
  values.resize(count);
  return values;
}

}  // namespace ovws
