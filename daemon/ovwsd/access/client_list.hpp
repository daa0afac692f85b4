/// The client list: which public keys may connect, and with which role (the file of
/// `security.clients`).
#pragma once

#include <map>
#include <string>

#include "core/base/result.hpp"
#include "proto/tables/description.hpp"

namespace ovws {

struct KnownClient {
  std::string name;
  Role role = Role::read;
};

/// Keyed by public key.
using ClientList = std::map<std::string, KnownClient>;

/// Strict JSON with comments; all or nothing. Errors name the client and the field at fault.
Result<ClientList> parse_client_list(const std::string& json_text);
/// Errors name the file. A file that other users can write is refused.
Result<ClientList> load_client_list(const std::string& path);

}  // namespace ovws
