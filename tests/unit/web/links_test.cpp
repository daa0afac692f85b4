#include "daemon/web/links.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/own_folder.hpp"

namespace ovws::web {
namespace {

class LinksTest : public testing::Test {
 protected:
  const std::string folder = own_folder("links");
  const std::string path = folder + "/links";

  LinksTest() { std::filesystem::create_directory(folder); }
  ~LinksTest() override { std::filesystem::remove_all(folder); }

  std::string text() const {
    std::stringstream all;
    all << std::ifstream(path).rdbuf();
    return all.str();
  }
};

TEST_F(LinksTest, StayGoodOverARestartAndAreNobodyElses) {
  const auto first = keep_links(path, "127.0.0.1:7704", true);
  ASSERT_TRUE(first) << first.error().reason;
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  EXPECT_EQ(text(), links_text("127.0.0.1:7704", *first));
  const auto again = keep_links(path, "127.0.0.1:8000", true);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->look, first->look);
  EXPECT_EQ(again->control, first->control);
  EXPECT_NE(text().find("http://127.0.0.1:8000/#" + first->look), std::string::npos);
}

TEST_F(LinksTest, WithoutControlThereIsNoLinkForIt) {
  ASSERT_TRUE(keep_links(path, "127.0.0.1:7704", true));
  const auto tokens = keep_links(path, "127.0.0.1:7704", false);
  ASSERT_TRUE(tokens);
  EXPECT_TRUE(tokens->control.empty());
  EXPECT_EQ(text().find("control"), std::string::npos);
}

TEST_F(LinksTest, RefusesAFileThatOthersReadOrThatIsSomethingElse) {
  ASSERT_TRUE(keep_links(path, "127.0.0.1:7704", true));
  ::chmod(path.c_str(), 0640);
  const auto read_by_others = keep_links(path, "127.0.0.1:7704", true);
  ASSERT_FALSE(read_by_others);
  EXPECT_EQ(read_by_others.error().code, Errc::invalid);
  for (const char* wrong : {"look short\n", "look http://x/#0123\n", "look\n#\n"}) {
    std::ofstream(path, std::ios::trunc) << wrong;
    ::chmod(path.c_str(), 0600);
    EXPECT_FALSE(keep_links(path, "127.0.0.1:7704", true)) << wrong;
  }
}

TEST_F(LinksTest, SaysThatItCannotWrite) {
  const auto tokens = keep_links(folder + "/no/links", "127.0.0.1:7704", true);
  ASSERT_FALSE(tokens);
  EXPECT_EQ(tokens.error().code, Errc::unavailable);
}

}  // namespace
}  // namespace ovws::web
