#include "daemon/ovws/parts/share.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

TEST(Share, a_range_is_two_positions) {
  EXPECT_EQ(*parse_range("0:100"), (Positions{0, 100}));
  EXPECT_EQ(*parse_range("7:7"), (Positions{7, 7}));
  EXPECT_EQ(text_of(*parse_range("12:345")), "12:345");
  for (const char* wrong : {"", ":", "1", "1:", ":1", "2:1", "-1:2", "1:2:3", " 1:2", "1:2 ", "a:b",
                            "1.0:2", "0:99999999999999999999", "1/2"}) {
    const auto read = parse_range(wrong);
    ASSERT_FALSE(read) << wrong;
    EXPECT_EQ(read.error().field, "frames");
    EXPECT_NE(read.error().reason.find("A:B"), std::string::npos);
  }
}

TEST(Share, a_shard_is_counted_from_1) {
  EXPECT_EQ(*parse_shard("1/1"), (Shard{1, 1}));
  EXPECT_EQ(*parse_shard("7/7"), (Shard{7, 7}));
  EXPECT_EQ(text_of(*parse_shard("3/100000")), "3/100000");
  for (const char* wrong : {"", "/", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "1 / 2", "x/2",
                            "1/100001", "99999999999999999999/2", "1:2"}) {
    const auto read = parse_shard(wrong);
    ASSERT_FALSE(read) << wrong;
    EXPECT_EQ(read.error().field, "shard");
  }
}

TEST(Share, shards_have_every_item_once_and_nearly_as_many_each) {
  for (const int of : {1, 2, 3, 7, 100}) {
    for (const std::uint64_t items : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{6},
                                      std::uint64_t{360}, std::uint64_t{1} << 40}) {
      std::uint64_t end = 0;
      for (int number = 1; number <= of; ++number) {
        const Positions share = consecutive({number, of}, items);
        EXPECT_EQ(share.begin, end);
        const std::uint64_t size = share.end - share.begin;
        EXPECT_TRUE(size == items / std::uint64_t(of) || size == items / std::uint64_t(of) + 1);
        end = share.end;
      }
      EXPECT_EQ(end, items);
    }
  }
}

}  // namespace
}  // namespace ovws
