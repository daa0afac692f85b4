#include "daemon/web/board.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

std::vector<std::string> texts(const std::vector<PacketPtr>& packets) {
  std::vector<std::string> found;
  for (const PacketPtr& packet : packets) found.push_back(packet->bytes);
  return found;
}

TEST(BoardTest, GivesOnlyTheNewestOfASlotAndAllOfASeriesInOrder) {
  Board board;
  board.put(Slot::wavefront, "w1");
  board.append(Series::event, "e1");
  board.put(Slot::wavefront, "w2");
  board.append(Series::event, "e2");
  std::uint64_t seen = 0;
  EXPECT_EQ(texts(board.newer(seen)), (std::vector<std::string>{"e1", "w2", "e2"}));
  EXPECT_TRUE(board.newer(seen).empty());
  board.put(Slot::image, "i1");
  EXPECT_EQ(texts(board.newer(seen)), std::vector<std::string>{"i1"});
  std::uint64_t late = 0;
  EXPECT_EQ(board.newer(late).size(), 4U);
}

TEST(BoardTest, ASlowReaderCostsNoMoreThanWhatIsKept) {
  Board board;
  for (int i = 0; i < 1000; ++i) {
    board.append(Series::event, "e");
    board.append(Series::trend, "t");
    board.append(Series::history, "h");
    board.put(Slot::image, std::string(1000, 'x'));
  }
  std::uint64_t seen = 0;
  EXPECT_EQ(board.newer(seen).size(), kEventsKept + kTrendKept + kHistoryKept + 1);
}

TEST(FramedTest, SaysBothLengths) {
  const std::array<std::byte, 3> binary{std::byte{7}, std::byte{8}, std::byte{9}};
  const std::string text(300, 'j');
  const std::string bytes = framed(text, binary);
  EXPECT_EQ(bytes.size(), 8U + 300U + 3U);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x2c\x01\x00\x00\x03\x00\x00\x00", 8));
  EXPECT_EQ(bytes.substr(308), "\x07\x08\x09");
}

}  // namespace
}  // namespace ovws::web
