#include "daemon/ovwsd/frames/frame_series.hpp"

#include <gtest/gtest.h>

#include "core/base/image.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {
namespace {

class FrameSeriesTest : public testing::Test {
 protected:
  FrameSeriesTest() {
    record_.saturated_fraction = 0.5F;
    record_.spot_count = 2;
    record_.spots.resize(8);
    record_.spots[0] = {10.0F, 11.0F, 100.0F, 1.0F};
    record_.spots[1] = {30.0F, 11.0F, 100.0F, 1.0F};
  }
  FrameRecord& next() {
    ++record_.frame.frame_id;
    return record_;
  }

  FrameRecord record_;
};

TEST_F(FrameSeriesTest, HoldsItsNumberOfFrames) {
  FrameSeries series(2, 2);
  for (int k = 0; k < 3; ++k) {
    record_.spots[0].x = float(10 + k);
    EXPECT_EQ(series.add(next()), k < 2);
  }
  const auto frames = series.take();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].spots[0].x, 10.0F);
  EXPECT_EQ(frames[1].spots.size(), 2U);  // a record has room for more
  EXPECT_EQ(frames[1].spots[0].x, 11.0F);
  EXPECT_EQ(frames[1].saturated_fraction, 0.5F);
}

TEST_F(FrameSeriesTest, HoldsWhatCameSoFar) {
  FrameSeries series(5, 2);
  EXPECT_TRUE(series.add(next()));
  EXPECT_EQ(series.take().size(), 1U);
}

TEST_F(FrameSeriesTest, RefusesFramesWithAnotherNumberOfSpots) {
  FrameSeries series(1, 2);
  for (const int other : {1, 3}) {
    record_.spot_count = other;
    EXPECT_FALSE(series.add(next()));
  }
}

TEST_F(FrameSeriesTest, RefusesFramesWithAnotherNumberOfWindows) {
  for (const std::size_t windows : {1U, 3U}) {
    FrameSeries series(1, 2, {std::vector<Vec2>(windows, Vec2{10.0, 10.0}), nullptr});
    EXPECT_FALSE(series.add(next()));
  }
}

/// Windows of half-width 10 px: each spot stands at the one bright pixel of its window.
TEST_F(FrameSeriesTest, MeasuresCentroidsInItsWindows) {
  Image<std::uint8_t> image(40, 20);
  image.at(12, 9) = 100;
  record_.frame.image = view_of(image);
  FrameSeries series(1, 2, {{{10, 10}, {30, 10}}, nullptr});
  EXPECT_TRUE(series.needs_pixels());
  EXPECT_TRUE(series.add(next()));
  const auto frames = series.take();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].spots[0].x, 12.0F);
  EXPECT_EQ(frames[0].spots[0].y, 9.0F);
  EXPECT_FALSE(frames[0].spots[1].found());  // dark
  EXPECT_EQ(frames[0].saturated_fraction, 0.5F);
}

/// Finds every spot where it starts.
class FindsAtTheStart final : public SpotTracker {
 public:
  TrackScratch make_scratch() const override { return {}; }
  SpotFix track(const ImageView&, Vec2 start_px, TrackScratch&) const OVWS_NONBLOCKING override {
    return {float(start_px.x), float(start_px.y), 100.0F, 1.0F};
  }
};

TEST_F(FrameSeriesTest, LooksForLostSpotsAtTheirStarts) {
  record_.spots[1] = {};
  const auto tracker = std::make_shared<FindsAtTheStart>();
  FrameSeries nowhere(1, 2, {.tracker = tracker});
  FrameSeries somewhere(1, 2, {.tracker = tracker, .starts_px = {{1, 2}, {3, 4}}});
  EXPECT_TRUE(nowhere.add(next()));
  EXPECT_TRUE(somewhere.add(record_));
  EXPECT_FALSE(nowhere.take()[0].spots[1].found());
  const auto spots = somewhere.take()[0].spots;
  EXPECT_EQ(spots[0].x, 10.0F);  // where the frame has it
  EXPECT_EQ(spots[1].x, 3.0F);
}

}  // namespace
}  // namespace ovws
