#include "daemon/ovwsd/access/client_list.hpp"

#include <sys/stat.h>

#include <algorithm>

#include "daemon/shared/key_file.hpp"
#include "proto/reader.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

constexpr int kMaxDepth = 8;
constexpr std::size_t kMaxClients = 1000;
constexpr std::size_t kMaxNameBytes = 64;

void read_client(ObjectReader& r, ClientList& list) {
  KnownClient client;
  std::string key;
  int role = -1;
  for (const char* required : {"name", "key", "role"}) r.require(required);
  r.string("name", client.name);
  r.string("key", key);
  r.choice("role", role, kNames<Role>());
  if (r.failed()) return;
  client.role = Role(role);
  if (client.name.empty() || client.name.size() > kMaxNameBytes) {
    return r.fault("name", "must have 1 to 64 bytes");
  }
  const bool taken = std::any_of(list.begin(), list.end(), [&client](const auto& entry) {
    return entry.second.name == client.name;
  });
  if (taken) return r.fault("name", "\"" + client.name + "\" is given twice");
  if (!is_curve_key(key)) return r.fault("key", "must be a public key of 40 characters");
  if (!list.emplace(key, client).second) r.fault("key", "is given twice");
}

}  // namespace

Result<ClientList> parse_client_list(const std::string& json_text) {
  const auto json = parse_strict_json(json_text, kMaxDepth, JsonComments::allowed);
  if (!json) return fail(Errc::invalid, "", json.error().reason);
  ClientList list;
  ObjectReader r(*json, "");
  r.require("clients");
  r.objects("clients", kMaxClients,
            [&list](ObjectReader& client, std::size_t) { read_client(client, list); });
  if (auto done = r.finish(); !done) return fail(done.error());
  return list;
}

Result<ClientList> load_client_list(const std::string& path) {
  const auto text = read_kept_file(
      path, S_IWOTH, "other users can change it and add clients: run chmod o-w on it");
  if (!text) return fail(text.error());
  auto list = parse_client_list(*text);
  if (list) return list;
  Error error = list.error();
  error.reason = path + ": " + error.reason;
  return fail(std::move(error));
}

}  // namespace ovws
