#include "daemon/web/access.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

const Tokens kTokens{"0123456789abcdef0123456789abcdef", "fedcba9876543210fedcba9876543210"};

class AccessTest : public testing::Test {
 protected:
  Access access{{"127.0.0.1:7704", "localhost:7704"}, kTokens};

  static RequestHead head(const char* method, const char* target, const std::string& token = "") {
    RequestHead head;
    head.method = method;
    head.target = target;
    head.host = "127.0.0.1:7704";
    if (!token.empty()) head.authorization = "Bearer " + token;
    return head;
  }
  void expect_refused(const RequestHead& head, Refusal why) const {
    const auto right = access.judge(head);
    ASSERT_FALSE(right);
    EXPECT_EQ(row_of(right.error()).name, row_of(why).name);
  }
};

TEST_F(AccessTest, GivesThePageToEverybodyWhoCallsItByItsName) {
  for (const char* path : {"/", "/index.html", "/style.css", "/main.js", "/icon.svg"}) {
    EXPECT_EQ(access.judge(head("GET", path)), Right::page) << path;
  }
  RequestHead by_name = head("GET", "/");
  by_name.host = "localhost:7704";
  by_name.fetch_site = "cross-site";  // a link from elsewhere
  EXPECT_EQ(access.judge(by_name), Right::page);
}

TEST_F(AccessTest, RefusesANameThatSomebodyMadePointHere) {
  for (const char* host : {"evil.example", "evil.example:7704", "127.0.0.1", "127.0.0.1:80", ""}) {
    RequestHead rebound = head("GET", "/");
    rebound.host = host;
    expect_refused(rebound, Refusal::host);
  }
}

TEST_F(AccessTest, RefusesAnotherOriginEvenWithTheToken) {
  for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:7704.evil.example",
                             "http://localhost:7704"}) {
    RequestHead foreign = head("POST", "/rpc", kTokens.control);
    foreign.origin = origin;
    expect_refused(foreign, Refusal::origin);
  }
  RequestHead foreign = head("GET", "/stream", kTokens.look);
  foreign.fetch_site = "cross-site";
  expect_refused(foreign, Refusal::origin);
  RequestHead own = head("POST", "/rpc", kTokens.control);
  own.origin = "http://127.0.0.1:7704";
  own.fetch_site = "same-origin";
  EXPECT_EQ(access.judge(own), Right::control);
}

TEST_F(AccessTest, AsksForTheTokenOfTheRight) {
  for (const char* path : {"/stream", "/hologram.png", "/image?x=0"}) {
    expect_refused(head("GET", path), Refusal::token);
    expect_refused(head("GET", path, "wrong"), Refusal::token);
    expect_refused(head("GET", path, kTokens.look + "0"), Refusal::token);
    EXPECT_EQ(access.judge(head("GET", path, kTokens.look)), Right::look);
    EXPECT_EQ(access.judge(head("GET", path, kTokens.control)), Right::control);
  }
  expect_refused(head("POST", "/rpc"), Refusal::token);
  expect_refused(head("POST", "/rpc", kTokens.look), Refusal::right);
}

TEST_F(AccessTest, LeavesADownloadWithoutATokenToItsTicket) {
  RequestHead download = head("GET", "/recording?name=run-1&ticket=0");
  EXPECT_EQ(access.judge(download), Right::page);
  download.authorization = "Bearer " + kTokens.look;
  EXPECT_EQ(access.judge(download), Right::look);
  download.fetch_site = "cross-site";
  expect_refused(download, Refusal::origin);
  expect_refused(head("GET", "/recordings"), Refusal::token);
  expect_refused(head("POST", "/ticket"), Refusal::token);
  EXPECT_EQ(access.judge(head("POST", "/ticket", kTokens.look)), Right::look);
}

TEST_F(AccessTest, NobodyControlsWithoutATokenForIt) {
  access = Access({"127.0.0.1:7704"}, {kTokens.look, ""});
  RequestHead empty = head("POST", "/rpc");
  empty.authorization = "Bearer ";
  expect_refused(empty, Refusal::token);
  expect_refused(head("POST", "/rpc", kTokens.control), Refusal::token);
}

TEST_F(AccessTest, KnowsItsPathsAndNothingElse) {
  for (const char* path : {"/../etc/passwd", "/page/../../x", "/%2e%2e/x", "//", "/style.css?x",
                           "/image", "/main.js/", "*", "http://127.0.0.1:7704/", ""}) {
    expect_refused(head("GET", path), Refusal::path);
  }
  expect_refused(head("GET", "/rpc", kTokens.control), Refusal::method);
  expect_refused(head("DELETE", "/"), Refusal::method);
}

TEST_F(AccessTest, RefusesABodyOfUnknownOrGreatLength) {
  RequestHead large = head("POST", "/rpc", kTokens.control);
  large.content_length = kMaxBodyBytes + 1;
  expect_refused(large, Refusal::size);
  large.content_length = kMaxBodyBytes;
  EXPECT_EQ(access.judge(large), Right::control);
  large.chunked = true;
  expect_refused(large, Refusal::size);
}

TEST(RefusalLogTest, CountsEachKind) {
  RefusalLog log;
  log.add(Refusal::host, {}, "127.0.0.1");
  log.add(Refusal::host, {}, "127.0.0.1");
  log.add(Refusal::token, {}, "127.0.0.1");
  const auto counts = log.counts();
  EXPECT_EQ(counts["host"], 2);
  EXPECT_EQ(counts["token"], 1);
  EXPECT_EQ(counts["path"], 0);
}

TEST(TokensTest, AreLongAndNeverTheSame) {
  const Tokens one = make_tokens(true);
  const Tokens other = make_tokens(true);
  EXPECT_EQ(one.look.size(), 32U);
  EXPECT_NE(one.look, one.control);
  EXPECT_NE(one.look, other.look);
  EXPECT_EQ(make_tokens(false).control, "");
}

}  // namespace
}  // namespace ovws::web
