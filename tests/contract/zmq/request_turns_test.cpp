#include "drivers/zmq/request_turns.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

struct Rig {
  std::shared_ptr<ReplyBox> box = std::make_shared<ReplyBox>();
  RequestTurns turns{box};

  bool push(const std::string& client, std::string bytes, std::string binary = {}) {
    return turns.push({{client}, {std::move(bytes), std::move(binary), ""}, true});
  }
  /// Bytes of the next requests, each of which is answered at once.
  std::string next(int count) {
    std::string order;
    for (int k = 0; k < count; ++k) {
      auto turn = turns.next();
      order += turn ? turn->request.body.bytes + " " : "- ";
    }
    return order;
  }
};

TEST(RequestTurns, ServesClientsInTurnAndEachInItsOrder) {
  Rig rig;
  for (const char* bytes : {"a1", "a2", "a3", "a4"}) rig.push("a", bytes);
  rig.push("b", "b1");
  rig.push("c", "c1");
  rig.push("b", "b2");
  EXPECT_EQ(rig.next(8), "a1 b1 c1 a2 b2 a3 a4 - ");
}

TEST(RequestTurns, PassesOverAClientWithoutRoomUntilItHasSome) {
  Rig rig;
  rig.push("a", "a1");
  rig.push("b", "b1");
  auto first = rig.turns.next();
  ASSERT_TRUE(first);
  rig.box->reply_to({"a"}, first->client, 2)(std::string(kMaxPerClient.reply_bytes, 'x'), nullptr);
  rig.push("a", "a2");
  EXPECT_EQ(rig.next(2), "b1 - ");
  rig.box->sent(*first->client, kMaxPerClient.reply_bytes);
  EXPECT_EQ(rig.next(1), "a2 ");
}

TEST(RequestTurns, BoundsTheBytesThatWaitForAClientAndLetsOthersIn) {
  Rig rig;
  const std::string large(64 << 10, 'x');
  std::size_t taken = 0;
  while (taken < 1000 && rig.push("a", large)) ++taken;
  EXPECT_GT(taken, 100u);
  EXPECT_LE(taken * large.size(), RequestTurns::kMaxClientBytes);
  EXPECT_TRUE(rig.push("b", large));
  for (int k = 0; k < 10; ++k) {
    const std::string client = "c" + std::to_string(k);
    while (rig.push(client, large)) ++taken;
  }
  EXPECT_LE(taken * large.size(), RequestTurns::kMaxTotalBytes + 12 * large.size());
  EXPECT_TRUE(rig.push("d", large));
}

TEST(RequestTurns, QueuesAPictureBesideRequestsOfOthers) {
  Rig rig;
  rig.push("a", "a1");
  EXPECT_TRUE(rig.push("b", "b1", std::string(RequestTurns::kMaxClientBytes + 1, 'x')));
  EXPECT_EQ(rig.next(2), "a1 b1 ");
}

TEST(RequestTurns, QueuesAPictureOfAnySizeOnlyAlone) {
  Rig rig;
  const std::string picture(RequestTurns::kMaxTotalBytes + 1, 'x');
  EXPECT_TRUE(rig.push("a", "a1", picture));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(rig.push("b" + std::to_string(k), "b1", picture));
  EXPECT_TRUE(rig.push("c", "c1"));
}

TEST(RequestTurns, RemembersWhatAClientHasOutstandingWhateverNumberComesAndGoes) {
  Rig rig;
  const auto load = rig.turns.load_of("a");
  const auto reply = rig.box->reply_to({"a"}, load, 2);
  for (int k = 0; k < 1000; ++k) {
    rig.push("b" + std::to_string(k), "b");
    rig.turns.next();
  }
  EXPECT_EQ(rig.turns.load_of("a"), load);
}

}  // namespace
}  // namespace ovws
