#include "daemon/ovwsd/settings/key_file_check.hpp"

#include <gtest/gtest.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/shared/key_file.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

constexpr uid_t kOther = 65534;  // the user nobody

/// A daemon's keys and clients, in a folder that every user may enter.
class KeyFileChecks : public testing::Test {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "needs root, to give files to another user";
    if (::getpwuid(kOther) == nullptr) GTEST_SKIP() << "no user has the number 65534 (nobody)";
    other_ = ::getpwuid(kOther)->pw_name;
    fs::create_directories(folder_);
    fs::permissions(folder_, fs::perms(0755));
    ASSERT_TRUE(write_key_file(secret_, {make_key_pair().value(), ""}, false));
    std::ofstream(clients_) << R"({"clients": []})";
    fs::permissions(clients_, fs::perms(0644));
    config_.security = {secret_, clients_};
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void give(const std::string& path, uid_t user) {
    ASSERT_EQ(::chown(path.c_str(), user, gid_t(-1)), 0);
  }
  KeyFileCheck check() const { return check_key_files(folder_ + "/ovwsd.json", config_); }
  KeyFileCheck check_as_other() const {
    EXPECT_EQ(::seteuid(kOther), 0);
    const KeyFileCheck found = check();
    EXPECT_EQ(::seteuid(0), 0);
    return found;
  }

  const std::string folder_ = own_folder("key_file_check");
  const std::string secret_ = folder_ + "/daemon.json", clients_ = folder_ + "/clients.json";
  std::string other_;
  Config config_;
};

TEST_F(KeyFileChecks, OfAnotherUserAreReadWithThatUsersRights) {
  give(secret_, kOther);
  KeyFileCheck found = check();
  EXPECT_FALSE(found.error) << found.error->reason;
  EXPECT_TRUE(found.read);
  EXPECT_EQ(found.user, other_);
  EXPECT_EQ(::geteuid(), 0U);
  fs::permissions(clients_, fs::perms(0640));
  found = check();
  ASSERT_TRUE(found.error);
  EXPECT_EQ(found.error->field, "security.clients");
  EXPECT_EQ(found.fix, "sudo chmod 644 " + clients_);
}

TEST_F(KeyFileChecks, OfRootAreRootsOwn) {
  EXPECT_FALSE(check().error);
  const KeyFileCheck found = check_as_other();
  ASSERT_TRUE(found.error);
  EXPECT_EQ(found.error->field, "security.secret_key");
  EXPECT_EQ(found.fix, "sudo chown " + other_ + " " + secret_);
}

TEST_F(KeyFileChecks, OfAThirdUserAreNotLookedAtAndTheClientsAre) {
  give(secret_, 1);
  KeyFileCheck found = check_as_other();
  EXPECT_FALSE(found.error);
  EXPECT_FALSE(found.read);
  EXPECT_EQ(found.user, ::getpwuid(1)->pw_name);
  std::ofstream(clients_) << "{}";
  found = check_as_other();
  ASSERT_TRUE(found.error);
  EXPECT_EQ(found.fix, "sudoedit " + clients_);
}

TEST_F(KeyFileChecks, SayHowAFileBecomesUsable) {
  fs::permissions(secret_, fs::perms(0640));
  EXPECT_EQ(check().fix, "sudo chmod 600 " + secret_);
  fs::permissions(secret_, fs::perms(0600));
  std::ofstream(secret_) << "{}";
  EXPECT_EQ(check().fix, "sudo ovws keygen -o " + secret_ + " --replace");
  fs::remove(secret_);
  EXPECT_NE(check().fix.find("sudo ovws keygen -o " + secret_ + " && sudo chown "),
            std::string::npos);
}

TEST_F(KeyFileChecks, WithoutKeysAreAboutTheEndpoints) {
  config_.security = {};
  EXPECT_FALSE(check().error);
  config_.control.endpoint = "tcp://*:7702";
  const KeyFileCheck found = check();
  ASSERT_TRUE(found.error);
  EXPECT_EQ(found.error->field, "control.endpoint");
  EXPECT_EQ(found.fix, "");
}

}  // namespace
}  // namespace ovws
