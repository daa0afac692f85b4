#include "drivers/zmq/reply_box.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <thread>

namespace ovws {
namespace {

std::shared_ptr<ClientLoad> someone() {
  return std::make_shared<ClientLoad>();
}

bool readable(const ReplyBox& box) {
  pollfd item{box.wake_fd(), POLLIN, 0};
  return ::poll(&item, 1, 0) > 0;
}

TEST(ReplyBox, GivesEachReplyWithItsEnvelopeOnce) {
  const auto box = std::make_shared<ReplyBox>();
  const auto first = box->reply_to({"a", ""}, someone(), 10);
  const auto second = box->reply_to({"b"}, someone(), 10);
  EXPECT_FALSE(readable(*box));
  second("two", nullptr);
  second("again", nullptr);
  EXPECT_TRUE(readable(*box));
  const auto replies = box->collect();
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].envelope, Envelope{"b"});
  EXPECT_EQ(replies[0].bytes, "two");
  EXPECT_FALSE(readable(*box));
}

TEST(ReplyBox, CountsARequestUntilItIsAnsweredAndAReplyUntilItIsSent) {
  const auto box = std::make_shared<ReplyBox>();
  const auto client = someone();
  const auto reply = box->reply_to({"a"}, client, 10);
  EXPECT_EQ(client->requests, 1u);
  EXPECT_EQ(client->request_bytes, 10u);
  reply("four", nullptr);
  EXPECT_EQ(client->requests, 0u);
  EXPECT_EQ(client->request_bytes, 0u);
  EXPECT_EQ(client->replies, 1u);
  EXPECT_EQ(client->reply_bytes, 4u);
  EXPECT_FALSE(box->is_idle(*client));
  box->collect();
  EXPECT_FALSE(box->is_idle(*client));
  box->sent(*client, 4);
  EXPECT_TRUE(box->is_idle(*client));
  EXPECT_EQ(client->reply_bytes, 0u);
}

TEST(ReplyBox, LimitsTheBinaryFramesOfAllClients) {
  const auto box = std::make_shared<ReplyBox>();
  const auto first = box->reply_to({"a"}, someone(), kMaxBinaryRequestBytes);
  EXPECT_FALSE(box->has_room(*someone(), true));
  EXPECT_TRUE(box->has_room(*someone()));
  first("done", nullptr);
  EXPECT_TRUE(box->has_room(*someone(), true));
}

TEST(ReplyBox, IsFreeAgainAfterEmptyAndForgottenReplies) {
  const auto box = std::make_shared<ReplyBox>();
  const auto client = someone();
  box->reply_to({"a"}, client, 10)("", nullptr);
  box->reply_to({"b"}, client, 10);
  EXPECT_TRUE(box->is_idle(*client));
  EXPECT_TRUE(box->collect().empty());
}

TEST(ReplyBox, WakesTheServerWhenAClientWithoutRoomHasSomeAgain) {
  const auto box = std::make_shared<ReplyBox>();
  const auto client = someone(), other = someone();
  const std::string large(kMaxPerClient.reply_bytes, 'x');
  box->reply_to({"a"}, client, 10)(large, nullptr);
  box->collect();
  EXPECT_FALSE(box->has_room(*client));
  EXPECT_TRUE(box->has_room(*other));
  EXPECT_FALSE(readable(*box));
  box->sent(*client, large.size());
  EXPECT_TRUE(readable(*box));
  EXPECT_TRUE(box->has_room(*client));
}

TEST(ReplyBox, GivesAClientRoomForOneRequestWhateverOthersHaveOutstanding) {
  const auto box = std::make_shared<ReplyBox>();
  std::vector<SendReply> held;
  for (std::size_t k = 0; k < kMaxAllClients.requests; ++k) {
    held.push_back(box->reply_to({"a"}, someone(), 10));
  }
  const auto one = someone();
  EXPECT_TRUE(box->has_room(*one));
  held.push_back(box->reply_to({"b"}, one, 10));
  EXPECT_FALSE(box->has_room(*one));
}

TEST(ReplyBox, LivesAsLongAsAReplyMayComeAndThenEndsWithIt) {
  auto box = std::make_shared<ReplyBox>();
  const std::weak_ptr<ReplyBox> observed = box;
  const auto client = someone();
  auto late = box->reply_to({"a"}, client, 10);
  box.reset();
  ASSERT_FALSE(observed.expired());
  late("no server listens", nullptr);
  EXPECT_EQ(client->requests, 0u);
  EXPECT_EQ(client->request_bytes, 0u);
  EXPECT_FALSE(observed.expired());
  late = nullptr;
  EXPECT_TRUE(observed.expired());
  EXPECT_EQ(client.use_count(), 1) << "an uncollected reply is discarded";
}

TEST(ReplyBox, LosesNothingBetweenThreads) {
  constexpr int kThreads = 4, kEach = 2000;
  const auto box = std::make_shared<ReplyBox>();
  const auto client = someone();
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&box, client, t] {
      for (int k = 0; k < kEach; ++k) {
        const auto reply = box->reply_to({std::to_string(t)}, client, 10);
        if (k % 4 != 0) reply(k % 4 == 1 ? "" : std::to_string(t), nullptr);
      }
    });
  }
  int collected = 0;
  while (collected < kThreads * kEach / 2) {
    pollfd item{box->wake_fd(), POLLIN, 0};
    ASSERT_EQ(::poll(&item, 1, 10000), 1);
    for (const auto& reply : box->collect()) {
      EXPECT_EQ(reply.envelope, Envelope{reply.bytes});
      box->sent(*reply.client, reply.bytes.size());
      ++collected;
    }
  }
  for (auto& thread : threads) thread.join();
  EXPECT_TRUE(box->is_idle(*client));
}

}  // namespace
}  // namespace ovws
