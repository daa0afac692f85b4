/// Keys of CURVE, ZeroMQ's encryption, as texts of 40 characters (Z85).
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct KeyPair {
  std::string public_key;
  std::string secret_key;
};

/// What a client needs: its own pair, and the public key of the daemon that it means.
struct ClientKeys {
  KeyPair own;
  std::string server_key;
};

bool is_curve_key(const std::string& text);
/// Errors: Errc::unavailable, if this libzmq has no CURVE.
Result<KeyPair> make_key_pair();
/// None if `secret_key` is no key.
std::optional<std::string> public_key_of(const std::string& secret_key);

}  // namespace ovws
