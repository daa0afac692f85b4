/// Detection of frames that Aravis discarded, from its packet counters.
#include "drivers/aravis/stray_frames.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

constexpr std::uint64_t kPackets = 32;

void expect(const StrayFrames::Counts& counts, int duplicate, int out_of_order) {
  EXPECT_EQ(counts.duplicate, duplicate);
  EXPECT_EQ(counts.out_of_order, out_of_order);
}

TEST(StrayFrames, AWholeFrameMoreThanWasDeliveredIsADuplicate) {
  StrayFrames strays(kPackets);
  strays.delivered(7);
  expect(strays.discarded(kPackets), 1, 0);
  strays.delivered(8);
  expect(strays.discarded(kPackets), 0, 0);
  expect(strays.discarded(3 * kPackets), 2, 0);
}

TEST(StrayFrames, AfterANumberLeftOutItIsTheFrameOfThatNumber) {
  StrayFrames strays(kPackets);
  strays.delivered(7);
  strays.delivered(9);
  expect(strays.discarded(kPackets), 0, 1);
  expect(strays.discarded(2 * kPackets), 1, 0);
}

TEST(StrayFrames, AnIncompleteFrameLeavesNoNumberOut) {
  StrayFrames strays(kPackets);
  strays.delivered(7);
  strays.delivered_incomplete();
  strays.delivered(9);
  expect(strays.discarded(kPackets), 1, 0);
}

TEST(StrayFrames, AFrameMissingFor100FramesIsNoLongerExpected) {
  StrayFrames strays(kPackets);
  strays.delivered(1);
  for (std::uint64_t id = 3; id <= 103; ++id) strays.delivered(id);
  expect(strays.discarded(kPackets), 1, 0);
}

TEST(StrayFrames, DiscardedPacketsAddUpToAFrame) {
  StrayFrames strays(kPackets);
  strays.delivered(7);
  expect(strays.discarded(kPackets - 10), 0, 0);
  strays.delivered(8);
  expect(strays.discarded(kPackets), 1, 0);
}

TEST(StrayFrames, SinglePacketsAreNoFrame) {
  StrayFrames strays(kPackets);
  for (std::uint64_t id = 1; id <= 2 * kPackets; ++id) {
    strays.delivered(id);
    expect(strays.discarded(id), 0, 0);
    expect(strays.discarded(id), 0, 0);
  }
}

}  // namespace
}  // namespace ovws
