#include "drivers/zmq/reply_box.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <thread>

namespace ovws {
namespace {

bool readable(const ReplyBox& box) {
  pollfd item{box.wake_fd(), POLLIN, 0};
  return ::poll(&item, 1, 0) > 0;
}

TEST(ReplyBox, GivesEachReplyWithItsEnvelopeOnce) {
  const auto box = std::make_shared<ReplyBox>();
  const auto first = box->reply_to({"a", ""});
  const auto second = box->reply_to({"b"});
  EXPECT_EQ(box->pending(), 2u);
  EXPECT_FALSE(readable(*box));
  second("two");
  second("again");
  EXPECT_TRUE(readable(*box));
  const auto replies = box->collect();
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].first, Envelope{"b"});
  EXPECT_EQ(replies[0].second, "two");
  EXPECT_FALSE(readable(*box));
  EXPECT_EQ(box->pending(), 1u);
}

TEST(ReplyBox, IsFreeAgainAfterEmptyAndForgottenReplies) {
  const auto box = std::make_shared<ReplyBox>();
  box->reply_to({"a"})("");
  box->reply_to({"b"});
  EXPECT_EQ(box->pending(), 0u);
  EXPECT_TRUE(box->collect().empty());
}

TEST(ReplyBox, LivesAsLongAsAReplyMayCome) {
  std::function<void(std::string)> late;
  {
    const auto box = std::make_shared<ReplyBox>();
    late = box->reply_to({"a"});
  }
  late("nobody listens");
}

TEST(ReplyBox, LosesNothingBetweenThreads) {
  constexpr int kThreads = 4, kEach = 2000;
  const auto box = std::make_shared<ReplyBox>();
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&box, t] {
      for (int k = 0; k < kEach; ++k) {
        const auto reply = box->reply_to({std::to_string(t)});
        if (k % 4 != 0) reply(k % 4 == 1 ? "" : std::to_string(t));
      }
    });
  }
  int collected = 0;
  while (collected < kThreads * kEach / 2) {
    pollfd item{box->wake_fd(), POLLIN, 0};
    ASSERT_EQ(::poll(&item, 1, 10000), 1);
    for (const auto& [envelope, reply] : box->collect()) {
      EXPECT_EQ(envelope, Envelope{reply});
      ++collected;
    }
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(box->pending(), 0u);
}

}  // namespace
}  // namespace ovws
