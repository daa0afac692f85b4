#include "daemon/ovwsd/frames/frame_tap.hpp"

#include <gtest/gtest.h>

#include <new>
#include <thread>

#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/frames/measured_under.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;
using Needs = FrameTap::Needs;

class FrameTapTest : public testing::Test {
 protected:
  /// A tap for `frames` frames that notes the numbers of those which it used.
  FrameTap tap(Needs needs, int frames) {
    return {taps_, needs, frames, [this](const FrameRecord& record) {
              seen_.push_back(record.frame.frame_id);
              return usable_;
            }};
  }
  const FrameRecord& next() {
    ++record_.frame.frame_id;
    return record_;
  }

  FrameTaps taps_;
  FrameRecord record_;
  bool usable_ = true;
  std::vector<std::uint64_t> seen_;
};

TEST_F(FrameTapTest, ServesTheNextFramesAndNoMore) {
  taps_.serve_numbers(next());  // before any tap is open
  FrameTap open = tap(Needs::numbers, 2);
  for (int k = 0; k < 3; ++k) taps_.serve_numbers(next());
  EXPECT_EQ(seen_, (std::vector<std::uint64_t>{2, 3}));
  EXPECT_TRUE(open.done());
  EXPECT_TRUE(open.wait_for(0ms));
}

TEST_F(FrameTapTest, CountsOnlyTheFramesThatAreUsed) {
  FrameTap open = tap(Needs::numbers, 1);
  usable_ = false;
  for (int k = 0; k < 5; ++k) taps_.serve_numbers(next());
  EXPECT_EQ(open.used(), 0);
  EXPECT_FALSE(open.wait_for(1ms));
  EXPECT_GT(open.idle_s(), 0.0);
  usable_ = true;
  taps_.serve_numbers(next());
  EXPECT_EQ(seen_.size(), 6U);
  EXPECT_TRUE(open.done());
}

TEST_F(FrameTapTest, ATapForPixelsIsServedWithPixelsOnly) {
  EXPECT_FALSE(taps_.wants_pixels());
  const FrameTap open = tap(Needs::pixels, 1);
  EXPECT_TRUE(taps_.wants_pixels());
  taps_.serve_numbers(next());
  EXPECT_TRUE(seen_.empty());
  taps_.serve_pixels(next());
  EXPECT_EQ(seen_.size(), 1U);
  EXPECT_FALSE(taps_.wants_pixels());
}

TEST_F(FrameTapTest, AClosedTapIsNotServed) {
  FrameTap open = tap(Needs::pixels, 3);
  open.close();
  EXPECT_FALSE(taps_.wants_pixels());
  taps_.serve_pixels(next());
  EXPECT_TRUE(seen_.empty());
}

TEST_F(FrameTapTest, ServesSeveralTapsWithOneFrame) {
  const FrameTap first = tap(Needs::numbers, 1), second = tap(Needs::numbers, 2);
  taps_.serve_numbers(next());
  taps_.serve_numbers(next());
  EXPECT_EQ(seen_, (std::vector<std::uint64_t>{1, 1, 2}));
}

TEST_F(FrameTapTest, ATapStaysOpenWhenMemoryRunsOut) {
  bool memory = false;
  const FrameTap open(taps_, Needs::pixels, 1, [&](const FrameRecord& /*record*/) {
    if (!memory) throw std::bad_alloc();
    return true;
  });
  EXPECT_THROW(taps_.serve_pixels(next()), std::bad_alloc);
  memory = true;
  taps_.serve_pixels(next());
  EXPECT_TRUE(open.done());
}

/// The publish thread serves while others open taps, wait and close them.
TEST_F(FrameTapTest, IsUsedFromManyThreads) {
  std::atomic<bool> end{false};
  std::thread publisher([&] {
    FrameRecord record;
    while (!end) {
      ++record.frame.frame_id;
      taps_.serve_numbers(record);
    }
  });
  const auto requester = [this] {
    for (int round = 0; round < 200; ++round) {
      std::vector<std::uint64_t> ids;
      FrameTap open(taps_, Needs::numbers, 20, [&ids](const FrameRecord& record) {
        ids.push_back(record.frame.frame_id);
        return true;
      });
      if (round % 2 == 0) continue;  // closed at once
      ASSERT_TRUE(open.wait_for(10s));
      ASSERT_EQ(ids.size(), 20U);
      for (std::size_t k = 1; k < ids.size(); ++k) ASSERT_EQ(ids[k], ids[k - 1] + 1);
    }
  };
  std::thread other(requester);
  requester();
  other.join();
  end = true;
  publisher.join();
}

TEST_F(FrameTapTest, AFailingTapTakesNoFrameFromTheOthers) {
  const FrameTap failing(taps_, Needs::pixels, 1,
                         [](const FrameRecord& /*record*/) -> bool { throw std::bad_alloc(); });
  const FrameTap other = tap(Needs::pixels, 1);
  EXPECT_THROW(taps_.serve_pixels(next()), std::bad_alloc);
  EXPECT_TRUE(other.done());
  EXPECT_FALSE(failing.done());
}

class MeasuredTest : public testing::Test {
 protected:
  MeasuredTest() {
    plan_.sensor_epoch = 5;
    record_.plan = &plan_;
    record_.hologram_id = 9;
    record_.settled = record_.still = record_.settings_known = true;
  }
  const MeasuredUnder under_{5, 9};
  MeasurementPlan plan_;
  FrameRecord record_;
};

TEST_F(MeasuredTest, TakesTheFramesOfThisSensorAndHologram) {
  EXPECT_TRUE(under_.settled(record_));
  EXPECT_TRUE(under_.still(record_));
}

TEST_F(MeasuredTest, TakesNoFrameOfAnythingElse) {
  MeasurementPlan other_epoch;
  other_epoch.sensor_epoch = 6;
  std::vector<FrameRecord> others(4, record_);
  others[0].plan = &other_epoch;
  others[1].hologram_id = 8;
  others[2].settled = others[2].still = false;
  for (int k = 0; k < 3; ++k) {
    EXPECT_FALSE(under_.settled(others[std::size_t(k)])) << k;
    EXPECT_FALSE(under_.still(others[std::size_t(k)])) << k;
  }
  others[3].settings_known = false;
  EXPECT_TRUE(under_.settled(others[3]));
  EXPECT_FALSE(under_.still(others[3]));
}

TEST_F(MeasuredTest, TakesFramesOfTheGivenExposureAndGainOnly) {
  const MeasuredUnder under{5, 9, CameraSettings{}};
  record_.exposure_us = CameraSettings{}.exposure_us;
  EXPECT_TRUE(under.settled(record_) && under.still(record_));
  std::vector<FrameRecord> others(4, record_);
  others[0].exposure_us = others[1].gain_db = others[2].gain_raw = 1.0;
  others[3].settings_known = false;
  for (const FrameRecord& other : others) {
    EXPECT_FALSE(under.settled(other) || under.still(other));
  }
}

/// Usable frames of one mode, the last one of another hologram than its plan's.
TEST_F(MeasuredTest, AFeedHoldsUsableFramesUntilItIsFull) {
  plan_.hologram_id = 9;
  plan_.modes_j = {3};
  plan_.correction = {{3, 0.5}};
  record_.coefficients = record_.sigma_waves = {0.25F};
  record_.mode_count = 1;
  FrameTaps taps;
  FrameFeed feed(taps, 2, is_of_own_hologram);
  for (const std::uint64_t hologram_id : {9U, 8U, 9U, 9U}) {
    record_.hologram_id = hologram_id;
    ++record_.frame.frame_id;
    taps.serve_numbers(record_);
  }
  FrameCopy copy;
  std::vector<std::uint64_t> ids;
  while (feed.next(copy, 0us)) ids.push_back(copy.frame.frame_id);
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(feed.tap().used(), 2);
  EXPECT_EQ(copy.measured(copy.coefficients).front(), 0.25F);
  EXPECT_EQ(copy.shown().front().waves, 0.5);
}

}  // namespace
}  // namespace ovws
