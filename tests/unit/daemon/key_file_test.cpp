#include "daemon/shared/key_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

/// A folder, and the path of a key file in it.
class KeyFiles : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  std::string text() const {
    std::ostringstream text;
    text << std::ifstream(path_).rdbuf();
    return text.str();
  }
  void put(const std::string& text) const {
    std::ofstream(path_) << text;
    fs::permissions(path_, fs::perms(0600));
  }
  unsigned mode() const { return unsigned(fs::status(path_).permissions()); }
  std::string reason() const {
    const auto loaded = load_key_file(path_);
    EXPECT_EQ(loaded ? "" : loaded.error().field, "path");
    return loaded ? "" : loaded.error().reason;
  }
  auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  const std::string folder_ = own_folder("key_file");
  const std::string path_ = folder_ + "/key.json";
  const KeyFile keys_{make_key_pair().value(), make_key_pair().value().public_key};
};

TEST_F(KeyFiles, AreReadAsTheyWereWritten) {
  const mode_t before = ::umask(0);
  const auto written = write_key_file(path_, keys_, false);
  ::umask(before);
  ASSERT_TRUE(written) << written.error().reason;
  EXPECT_EQ(mode(), 0600U);
  const auto read = load_key_file(path_);
  ASSERT_TRUE(read) << read.error().reason;
  EXPECT_EQ(read->pair.public_key, keys_.pair.public_key);
  EXPECT_EQ(read->pair.secret_key, keys_.pair.secret_key);
  EXPECT_EQ(read->server_key, keys_.server_key);
}

TEST_F(KeyFiles, OfTheServiceManagerMayBeReadByTheGroup) {
  ASSERT_TRUE(write_key_file(path_, keys_, false));
  fs::permissions(path_, fs::perms(0440));
  EXPECT_NE(reason().find("chmod 600"), std::string::npos);
  EXPECT_EQ(credential_path("key.json"), "");
  ::setenv("CREDENTIALS_DIRECTORY", folder_.c_str(), 1);
  EXPECT_EQ(credential_path("key.json"), path_);
  EXPECT_EQ(credential_path("no.json"), "");
  EXPECT_TRUE(load_key_file(path_));
  fs::permissions(path_, fs::perms(0444));
  EXPECT_FALSE(load_key_file(path_));
  ::unsetenv("CREDENTIALS_DIRECTORY");
}

TEST_F(KeyFiles, AreNotOverwrittenUnlessRequested) {
  put("precious");
  const auto written = write_key_file(path_, keys_, false);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Errc::refused);
  EXPECT_EQ(text(), "precious");
  EXPECT_EQ(files(), 1);
}

TEST_F(KeyFiles, ReplaceTheOldOneWhateverItsModeWas) {
  put("old");
  fs::permissions(path_, fs::perms(0666));
  const std::ifstream reader(path_);  // an open reader keeps the complete old file
  ASSERT_TRUE(write_key_file(path_, keys_, true));
  EXPECT_EQ(mode(), 0600U);
  EXPECT_EQ(load_key_file(path_).value().pair.secret_key, keys_.pair.secret_key);
  std::ostringstream old;
  old << reader.rdbuf();
  EXPECT_EQ(old.str(), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(KeyFiles, ReplaceALinkAndNotWhatItLeadsTo) {
  const std::string elsewhere = folder_ + "/elsewhere";
  std::ofstream(elsewhere) << "not ours";
  fs::create_symlink(elsewhere, path_);
  ASSERT_TRUE(write_key_file(path_, keys_, true));
  EXPECT_FALSE(fs::is_symlink(path_));
  EXPECT_TRUE(load_key_file(path_));
  EXPECT_EQ(fs::file_size(elsewhere), std::string("not ours").size());
}

TEST_F(KeyFiles, ThatCannotBeReplacedStayAndLeaveNothingBeside) {
  const std::string link = folder_ + "/link";
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  fs::create_symlink(path_, link);
  for (const std::string& path : {path_, link}) {
    EXPECT_FALSE(write_key_file(path, keys_, false));
    const auto written = write_key_file(path, keys_, true);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().reason, path + " is not a regular file: choose another name");
  }
  EXPECT_TRUE(fs::is_fifo(path_));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(files(), 2);
}

TEST_F(KeyFiles, AreRefusedIfOthersCanReadThem) {
  ASSERT_TRUE(write_key_file(path_, keys_, false));
  for (const unsigned open : {0640U, 0604U, 0620U, 0610U}) {
    fs::permissions(path_, fs::perms(open));
    EXPECT_NE(reason().find("chmod 600"), std::string::npos) << open;
  }
  fs::permissions(path_, fs::perms(0400));
  EXPECT_TRUE(load_key_file(path_));
}

TEST_F(KeyFiles, AreRefusedIfTheyAreNoFileOrNotWhatKeygenWrites) {
  EXPECT_NE(reason().find("cannot be read"), std::string::npos);
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  EXPECT_NE(reason().find("is not a file"), std::string::npos);
  fs::remove(path_);
  ASSERT_TRUE(write_key_file(path_, {keys_.pair, "short"}, false));
  EXPECT_NE(reason().find("server_key"), std::string::npos);
  ASSERT_TRUE(write_key_file(path_, {{keys_.server_key, keys_.pair.secret_key}, ""}, true));
  EXPECT_NE(reason().find("does not belong"), std::string::npos);
  for (const char* wrong : {"", "{", "[]", "{}", R"({"public_key": "a"})",
                            R"({"public_key": "a", "secret_key": "b", "more": 1})"}) {
    put(wrong);
    EXPECT_NE(reason(), "") << wrong;
  }
  put(std::string((1 << 20) + 1, ' '));
  EXPECT_NE(reason().find("larger"), std::string::npos);
}

}  // namespace
}  // namespace ovws
