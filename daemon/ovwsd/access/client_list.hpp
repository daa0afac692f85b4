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

/// Known clients, keyed by public key.
using ClientList = std::map<std::string, KnownClient>;

/// Parses the client list: strict JSON with comments. One invalid client rejects the whole list;
/// the error names this client and the field.
Result<ClientList> parse_client_list(const std::string& json_text);
/// Reads and parses the client file. Refuses a file that other users can write. Errors name the
/// file.
Result<ClientList> load_client_list(const std::string& path);

}  // namespace ovws
