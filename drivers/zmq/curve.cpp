#include "drivers/zmq/curve.hpp"

#include <zmq.h>

#include <array>
#include <cstdint>

namespace ovws {
namespace {

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kKeyText = 40;
using KeyText = std::array<char, kKeyText + 1>;

}  // namespace

bool is_curve_key(const std::string& text) {
  std::array<std::uint8_t, kKeyBytes> bytes{};
  return text.size() == kKeyText && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

Result<KeyPair> make_key_pair() {
  KeyText public_key{};
  KeyText secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
    return fail(Errc::unavailable, "",
                std::string("keys cannot be generated: this libzmq has no CURVE (") +
                    zmq_strerror(zmq_errno()) + ")");
  }
  return KeyPair{public_key.data(), secret_key.data()};
}

std::optional<std::string> public_key_of(const std::string& secret_key) {
  KeyText public_key{};
  if (!is_curve_key(secret_key)) return std::nullopt;
  if (zmq_curve_public(public_key.data(), secret_key.c_str()) != 0) return std::nullopt;
  return std::string(public_key.data());
}

}  // namespace ovws
