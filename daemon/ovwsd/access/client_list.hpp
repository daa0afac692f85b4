/// Who may connect, and what each may: the file of `security.clients`.
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

/// By public key.
using ClientList = std::map<std::string, KnownClient>;

/// Strict, whole or not at all. Errors name the client at fault.
Result<ClientList> parse_client_list(const std::string& json_text);
/// Errors name the file; one that others can change is refused.
Result<ClientList> load_client_list(const std::string& path);

}  // namespace ovws
