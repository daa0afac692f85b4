/// CURVE keys (ZeroMQ's encryption and authentication) as Z85 texts of 40 characters.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct KeyPair {
  std::string public_key;
  std::string secret_key;
};

/// Keys of a client: its own pair, and the public key of the daemon.
struct ClientKeys {
  KeyPair own;
  std::string server_key;
};

/// Whether `text` has the form of a key: 40 characters of Z85.
bool is_curve_key(const std::string& text);
/// Generates a random key pair. Errors: Errc::unavailable if this libzmq has no CURVE.
Result<KeyPair> make_key_pair();
/// Computes the public key that belongs to a secret key. None if `secret_key` is malformed.
std::optional<std::string> public_key_of(const std::string& secret_key);

}  // namespace ovws
