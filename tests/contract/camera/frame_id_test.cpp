/// Unwrapping of frame numbers.
#include "drivers/aravis/frame_id.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

using Width = FrameIdUnwrapper::Width;

TEST(FrameIdUnwrapper, BeginsWithTheCamerasOwnNumber) {
  EXPECT_EQ(FrameIdUnwrapper(Width::bits16).next(65401), 65401u);
  EXPECT_EQ(FrameIdUnwrapper(Width::bits64).next(0), 0u);
}

TEST(FrameIdUnwrapper, ConsecutiveFramesDifferByOneOverManyTurns) {
  FrameIdUnwrapper ids(Width::bits16);
  std::uint16_t raw = 65000;
  std::uint64_t last = ids.next(raw);
  for (int i = 0; i < 200'000; ++i) {
    raw = raw == 65535 ? 1 : std::uint16_t(raw + 1);
    const std::uint64_t id = ids.next(raw);
    ASSERT_EQ(id, last + 1) << "camera's number " << raw;
    last = id;
  }
}

TEST(FrameIdUnwrapper, LostFramesAreAGapOfTheirNumber) {
  FrameIdUnwrapper ids(Width::bits16);
  EXPECT_EQ(ids.next(10), 10u);
  EXPECT_EQ(ids.next(14), 14u);
}

TEST(FrameIdUnwrapper, AGapOverTheWrapCountsOnlyFramesThatExist) {
  FrameIdUnwrapper ids(Width::bits16);
  EXPECT_EQ(ids.next(65533), 65533u);
  // 65534, 65535, 1 and 2 are lost; there is no frame 0.
  EXPECT_EQ(ids.next(3), 65538u);
  EXPECT_EQ(ids.next(4), 65539u);
}

TEST(FrameIdUnwrapper, ANewStreamGoesOnWhereTheLastEndedWhateverItsNumber) {
  for (std::uint64_t first : {1u, 501u, 20000u, 65535u}) {
    FrameIdUnwrapper ids(Width::bits16);
    ids.next(499);
    EXPECT_EQ(ids.next(500), 500u);
    ids.restart();
    EXPECT_EQ(ids.next(first), 501u);
    EXPECT_EQ(ids.next(first == 65535 ? 1 : first + 1), 502u);
  }
}

TEST(FrameIdUnwrapper, ACounterSetBackIsNotAGapOfAWholeTurn) {
  FrameIdUnwrapper ids(Width::bits16);
  ids.next(5000);
  EXPECT_EQ(ids.next(1), 5001u);
  EXPECT_EQ(ids.next(2), 5002u);
  FrameIdUnwrapper wide(Width::bits64);
  wide.next(5000);
  EXPECT_EQ(wide.next(0), 5001u);
}

TEST(FrameIdUnwrapper, AFrameThatComesAgainHasItsNumberAgain) {
  for (const Width width : {Width::bits16, Width::bits64}) {
    FrameIdUnwrapper ids(width);
    ids.next(7);
    EXPECT_EQ(ids.next(7), 7u);
    EXPECT_EQ(ids.next(8), 8u);
  }
}

TEST(FrameIdUnwrapper, AFrameAfterALaterOneHasTheNumberItWouldHaveHad) {
  FrameIdUnwrapper ids(Width::bits16);
  ids.next(65534);
  EXPECT_EQ(ids.next(2), 65537u);
  EXPECT_EQ(ids.next(65535), 65535u);
  EXPECT_EQ(ids.next(1), 65536u);
  EXPECT_EQ(ids.next(3), 65538u);
  FrameIdUnwrapper wide(Width::bits64);
  wide.next(100);
  wide.next(102);
  EXPECT_EQ(wide.next(101), 101u);
  EXPECT_EQ(wide.next(103), 103u);
}

TEST(FrameIdUnwrapper, NoNumberLiesBeforeTheFirst) {
  FrameIdUnwrapper ids(Width::bits16);
  ids.next(1);
  EXPECT_EQ(ids.next(65530), 2u);
}

TEST(FrameIdUnwrapper, WideNumbersPassWithTheirGaps) {
  FrameIdUnwrapper ids(Width::bits64);
  EXPECT_EQ(ids.next(65535), 65535u);
  EXPECT_EQ(ids.next(65536), 65536u);
  EXPECT_EQ(ids.next(4'294'967'300), 4'294'967'300u);
}

}  // namespace
}  // namespace ovws
