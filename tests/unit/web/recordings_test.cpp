#include "daemon/web/recordings.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace ovws::web {
namespace {

namespace fs = std::filesystem;

TEST(DownloadQueryTest, TakesPlainNamesOnly) {
  EXPECT_EQ(parse_download("run-1.a")->name, "run-1.a");
  EXPECT_EQ(parse_download("run-1&ticket=abc")->ticket, "abc");
  for (const char* query : {"", "../run", "a/b", "%2e%2e%2frun", ".hidden", "run 1", "&ticket=abc",
                            "run\r\nSet-Cookie: a", "run&other=1"}) {
    EXPECT_FALSE(parse_download(query)) << query;
  }
}

TEST(TicketsTest, AreForOneDownloadOfOneRecordingSoon) {
  Tickets tickets;
  const auto now = Tickets::Clock::now();
  const std::string ticket = tickets.give("run-1", now);
  EXPECT_EQ(ticket.size(), 32U);
  EXPECT_FALSE(tickets.check({"run-1", ""}, now));
  EXPECT_FALSE(tickets.check({"run-1", ticket.substr(1)}, now));
  EXPECT_TRUE(tickets.check({"run-1", ticket}, now));
  EXPECT_TRUE(tickets.check({"run-1", ticket}, now)) << "its download has not begun";
  tickets.take({"run-1", ticket});
  EXPECT_FALSE(tickets.check({"run-1", ticket}, now)) << "used";
  const std::string other = tickets.give("run-1", now);
  EXPECT_FALSE(tickets.check({"run-2", other}, now)) << "another recording";
  EXPECT_FALSE(tickets.check({"run-1", other}, now)) << "used up by that";
  const std::string late = tickets.give("run-1", now);
  EXPECT_FALSE(tickets.check({"run-1", late}, now + Tickets::kLifetime)) << "too old";
}

TEST(TicketsTest, KeepsTheNewest) {
  Tickets tickets;
  const std::string first = tickets.give("run-1");
  const std::string second = tickets.give("run-1");
  for (std::size_t i = 1; i < Tickets::kMost; ++i) tickets.give("run-1");
  EXPECT_FALSE(tickets.check({"run-1", first}));
  EXPECT_TRUE(tickets.check({"run-1", second}));
}

class OpenRecordingTest : public testing::Test {
 protected:
  fs::path folder = fs::path(testing::TempDir()) / ("recordings-" + std::to_string(::getpid()));

  void SetUp() override {
    fs::create_directories(folder / "recordings");
    std::ofstream(folder / "secret.h5") << "secret";
    std::ofstream(folder / "recordings" / "run.h5") << "0123456789";
  }
  void TearDown() override { fs::remove_all(folder); }

  void expect_refused(const std::string& name, const std::string& reason) {
    const auto file = open_in_folder((folder / "recordings").string(), name);
    ASSERT_FALSE(file) << name;
    EXPECT_NE(file.error().reason.find(reason), std::string::npos) << file.error().reason;
  }
};

TEST_F(OpenRecordingTest, ReadsAFileInParts) {
  const auto file = open_in_folder((folder / "recordings").string(), "run");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->bytes(), 10U);
  EXPECT_EQ(file->read(0, 4), "0123");
  EXPECT_EQ(file->read(8, 4), "89");
  EXPECT_EQ(file->read(10, 4), "");
}

TEST_F(OpenRecordingTest, FollowsNoLinkAndOpensOnlyFiles) {
  const fs::path inside = folder / "recordings";
  fs::create_symlink(folder / "secret.h5", inside / "link.h5");
  fs::create_directory(inside / "folder.h5");
  ASSERT_EQ(::mkfifo((inside / "pipe.h5").c_str(), 0600), 0);
  expect_refused("link", "is a link");
  expect_refused("folder", "is not a file");
  expect_refused("pipe", "is not a file");
  expect_refused("nothing", "does not exist where ovws-web runs");
}

}  // namespace
}  // namespace ovws::web
