#include "daemon/ovwsd/access/client_list.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "drivers/zmq/curve.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

std::string client(const std::string& name, const std::string& key, const std::string& role) {
  return R"({"name": ")" + name + R"(", "key": ")" + key + R"(", "role": ")" + role + R"("})";
}

std::string list_of(const std::string& clients) {
  return R"({"clients": [)" + clients + "]}";
}

std::string new_key() {
  return make_key_pair().value().public_key;
}

TEST(ClientList, GivesNameAndRoleByKey) {
  const std::string one = new_key(), other = new_key();
  const auto list = parse_client_list(
      "// who may\n" + list_of(client("a", one, "read") + ", " + client("b", other, "control")));
  ASSERT_TRUE(list) << list.error().reason;
  ASSERT_EQ(list->size(), 2U);
  EXPECT_EQ(list->at(one).name, "a");
  EXPECT_EQ(list->at(one).role, Role::read);
  EXPECT_EQ(list->at(other).name, "b");
  EXPECT_EQ(list->at(other).role, Role::control);
  EXPECT_TRUE(parse_client_list(list_of("")).value().empty());
}

TEST(ClientList, NamesTheClientAtFaultAndTakesNone) {
  const std::string key = new_key(), good = client("a", key, "read") + ", ";
  const std::pair<std::string, const char*> wrong[]{
      {client("a", new_key(), "read"), "clients[1].name"},
      {client("", new_key(), "read"), "clients[1].name"},
      {client(std::string(65, 'n'), new_key(), "read"), "clients[1].name"},
      {client("b", key, "control"), "clients[1].key"},
      {client("b", key.substr(1), "read"), "clients[1].key"},
      {client("b", std::string(40, '~'), "read"), "clients[1].key"},
      {client("b", new_key(), "reed"), "clients[1].role"},
      {R"({"name": "b", "role": "read"})", "clients[1].key"},
      {R"({"name": "b", "key": ")" + new_key() + R"("})", "clients[1].role"},
      {R"({"name": "b", "key": ")" + new_key() + R"(", "role": "read", "more": 1})",
       "clients[1].more"},
      {"5", "clients[1]"}};
  for (const auto& [text, field] : wrong) {
    const auto list = parse_client_list(list_of(good + text));
    ASSERT_FALSE(list) << text;
    EXPECT_EQ(list.error().field, field) << text;
  }
  for (const char* text : {"", "{}", "[]", "{", R"({"clients": {}})", R"({"clients": [], "c": 1})",
                           R"({"clients": [], "clients": []})"}) {
    EXPECT_FALSE(parse_client_list(text)) << text;
  }
}

TEST(ClientList, OfAFileThatOthersCanChangeIsRefused) {
  const std::string folder = own_folder("client_list"), path = folder + "/clients.json";
  fs::create_directories(folder);
  std::ofstream(path) << list_of(client("a", new_key(), "read"));
  fs::permissions(path, fs::perms(0664));
  EXPECT_EQ(load_client_list(path).value().size(), 1U);
  fs::permissions(path, fs::perms(0646));
  EXPECT_NE(load_client_list(path).error().reason.find("chmod o-w"), std::string::npos);
  fs::permissions(path, fs::perms(0644));
  std::ofstream(path) << list_of("5");
  EXPECT_NE(load_client_list(path).error().reason.find(path), std::string::npos);
  fs::remove_all(folder);
  EXPECT_NE(load_client_list(path).error().reason.find(path), std::string::npos);
}

}  // namespace
}  // namespace ovws
