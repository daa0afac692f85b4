#include "daemon/shared/atomic_file.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/own_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

namespace ovws {
namespace {

namespace fs = std::filesystem;

std::string text_in(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// A folder with one file, "old".
class AtomicFile : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    ASSERT_TRUE(replace_file(path_, "old"));
  }
  void TearDown() override { fs::remove_all(folder_); }

  void expect_old_and_nothing_else() const {
    EXPECT_EQ(text_in(path_), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
  }

  const std::string folder_ = own_folder("atomic_file");
  const std::string path_ = folder_ + "/config.json";
};

std::vector<std::string> calls_seen;

std::string name_of(int fd) {
  return fs::read_symlink("/proc/self/fd/" + std::to_string(fd)).filename();
}

/// Records each call with the name of its file, and executes it.
const FileCalls kRecorder{[](int fd, const void* bytes, std::size_t count) {
                            calls_seen.push_back("write " + name_of(fd));
                            return ::write(fd, bytes, std::min<std::size_t>(count, 2));
                          },
                          [](int fd) {
                            calls_seen.push_back("fsync " + name_of(fd));
                            return ::fsync(fd);
                          },
                          [](const char* from, const char* to) {
                            calls_seen.push_back("rename " + fs::path(from).filename().string() +
                                                 " " + fs::path(to).filename().string());
                            return std::rename(from, to);
                          }};

template <int error>
int failing(int) {
  errno = error;
  return -1;
}

TEST_F(AtomicFile, TheNewContentReplacesTheOldWhole) {
  ASSERT_TRUE(replace_file(path_, "old, and longer"));
  ASSERT_TRUE(replace_file(path_, "new"));
  EXPECT_EQ(text_in(path_), "new");
}

TEST_F(AtomicFile, TheContentIsOnTheDiskBeforeTheNameIsAndTheNameBeforeItReturns) {
  calls_seen.clear();
  ASSERT_TRUE(replace_file(path_, "new", kRecorder));
  ASSERT_EQ(calls_seen.size(), 5U);
  const std::string temporary = calls_seen[0].substr(6);
  EXPECT_NE(temporary, "config.json");
  const std::vector<std::string> order{"write " + temporary, "write " + temporary,
                                       "fsync " + temporary, "rename " + temporary + " config.json",
                                       "fsync " + fs::path(folder_).filename().string()};
  EXPECT_EQ(calls_seen, order);
  EXPECT_EQ(text_in(path_), "new");
  calls_seen.clear();
  ASSERT_TRUE(remove_file(path_, kRecorder));
  EXPECT_EQ(calls_seen, std::vector<std::string>{"fsync " + fs::path(folder_).filename().string()});
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(remove_file(path_)) << "what is not there is removed";
}

TEST_F(AtomicFile, ALinkIsFollowedAndPermissionsStay) {
  fs::permissions(path_, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(path_, folder_ + "/link");
  ASSERT_TRUE(replace_file(folder_ + "/link", "new"));
  EXPECT_TRUE(fs::is_symlink(folder_ + "/link"));
  EXPECT_EQ(text_in(path_), "new");
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFile, AFolderThatIsNotThereIsAnErrorWithThePathAndTheWayOut) {
  const auto stored = replace_file("/nowhere/at/all.json", "x");
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().field, "path");
  EXPECT_NE(stored.error().reason.find("/nowhere/at/all.json"), std::string::npos);
  EXPECT_NE(stored.error().reason.find("create the folder"), std::string::npos);
}

TEST_F(AtomicFile, AWriteThatFailsHalfwayLeavesTheOldFileAndNothingElse) {
  const auto stored = [&] {
    const test::FileLimit limit(4096);
    return replace_file(path_, std::string(100000, 'x'));
  }();
  ASSERT_FALSE(stored);
  EXPECT_NE(stored.error().reason.find("free some space"), std::string::npos)
      << stored.error().reason;
  expect_old_and_nothing_else();
}

TEST_F(AtomicFile, AFullDiskAReadOnlyOneAndABrokenOneAreReportedWithTheRemedy) {
  FileCalls full;
  full.write = [](int fd, const void*, std::size_t) { return ssize_t(failing<ENOSPC>(fd)); };
  FileCalls broken;
  broken.fsync = failing<EIO>;
  FileCalls read_only;
  read_only.rename = [](const char*, const char*) { return failing<EROFS>(0); };
  FileCalls forbidden;
  forbidden.rename = [](const char*, const char*) { return failing<EACCES>(0); };
  const std::vector<std::pair<FileCalls, std::string>> cases{
      {full, "No space left on device: free some space"},
      {broken, "Input/output error: check the disk"},
      {read_only, "Read-only file system: the file system is read-only"},
      {forbidden, "Permission denied: give the user of this program write permission"}};
  for (const auto& [calls, reason] : cases) {
    const auto stored = replace_file(path_, "new", calls);
    ASSERT_FALSE(stored) << reason;
    EXPECT_EQ(stored.error().code, Errc::unavailable);
    EXPECT_NE(stored.error().reason.find(path_), std::string::npos);
    EXPECT_NE(stored.error().reason.find(reason), std::string::npos) << stored.error().reason;
    expect_old_and_nothing_else();
  }
}

TEST_F(AtomicFile, OnlyWhatWritersLeftBehindIsRemoved) {
  const std::vector<std::string> kept{"/config.json.bak", "/other.ovws-tmp", "/x.ovws-tmp.json"};
  for (const std::string& name : kept) std::ofstream(folder_ + name) << "mine";
  std::ofstream(folder_ + "/config.json.a1B2c3.ovws-tmp") << "half";
  std::ofstream(folder_ + "/twin.json.a1B2c3.ovws-tmp") << "half";
  EXPECT_EQ(remove_leftovers(folder_), 2);
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder_ + name)) << name;
  EXPECT_EQ(text_in(path_), "old");
  EXPECT_EQ(remove_leftovers("/nowhere/at/all"), 0);
}

mode_t mode_when_written = 0;

TEST_F(AtomicFile, OfASecretIsNobodyElsesFromTheBeginning) {
  fs::permissions(path_, fs::perms(0666));
  FileCalls calls;
  calls.write = [](int fd, const void* bytes, std::size_t count) {
    struct stat about {};
    mode_when_written = ::fstat(fd, &about) == 0 ? about.st_mode & 07777U : 07777U;
    return ::write(fd, bytes, count);
  };
  const mode_t before = ::umask(0);
  const auto replaced = replace_secret_file(path_, "secret", calls);
  ::umask(before);
  ASSERT_TRUE(replaced) << replaced.error().reason;
  EXPECT_EQ(mode_when_written, 0600U);
  EXPECT_EQ(unsigned(fs::status(path_).permissions()), 0600U);
  EXPECT_EQ(text_in(path_), "secret");
}

TEST_F(AtomicFile, OfASecretKeepsItsOwnerAndAStricterMode) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root, to give a file to another user";
  constexpr uid_t kOther = 65534;
  ASSERT_EQ(::chown(path_.c_str(), kOther, kOther), 0);
  fs::permissions(path_, fs::perms(0400));
  ASSERT_TRUE(replace_secret_file(path_, "secret"));
  struct stat about {};
  ASSERT_EQ(::stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, kOther);
  EXPECT_EQ(about.st_gid, kOther);
  EXPECT_EQ(about.st_mode & 07777U, 0400U);
  fs::remove(path_);
  fs::create_symlink(folder_ + "elsewhere", path_);
  ASSERT_EQ(::lchown(path_.c_str(), kOther, kOther), 0);
  ASSERT_TRUE(replace_secret_file(path_, "secret"));
  ASSERT_EQ(::lstat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_uid, 0U);
}

}  // namespace
}  // namespace ovws
