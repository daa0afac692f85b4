#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "daemon/config_file.hpp"

namespace ovws {
namespace {

std::string content_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(StoredFile, TheNewContentReplacesTheOldWhole) {
  const std::string path = testing::TempDir() + "ovws_stored_file";
  ASSERT_TRUE(replace_file(path, "old, and longer"));
  ASSERT_TRUE(replace_file(path, "new"));
  EXPECT_EQ(content_of(path), "new");
  std::filesystem::remove(path);
}

TEST(StoredFile, ALinkIsFollowedAndPermissionsStay) {
  namespace fs = std::filesystem;
  const fs::path folder = testing::TempDir() + "ovws_stored_file_link";
  fs::create_directories(folder);
  std::ofstream(folder / "target") << "old";
  fs::permissions(folder / "target", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(folder / "target", folder / "link");
  ASSERT_TRUE(replace_file(folder / "link", "new"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(content_of(folder / "target"), "new");
  EXPECT_EQ(fs::status(folder / "target").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  fs::remove_all(folder);
}

TEST(StoredFile, AFolderThatIsNotThereIsAnErrorWithThePath) {
  const auto stored = replace_file("/nowhere/at/all.json", "x");
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().field, "path");
  EXPECT_NE(stored.error().reason.find("/nowhere/at/all.json"), std::string::npos);
}

TEST(StoredFile, AWriteThatFailsHalfwayLeavesTheOldFileAndNothingElse) {
  const std::string folder = testing::TempDir() + "ovws_stored_file_limit";
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/config.json";
  ASSERT_TRUE(replace_file(path, "old"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const auto stored = replace_file(path, std::string(100000, 'x'));
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_FALSE(stored);
  EXPECT_EQ(content_of(path), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace ovws
