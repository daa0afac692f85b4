#include "daemon/ovwsd/frames/frame_series.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "core/base/image.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {
namespace {

constexpr std::uint64_t kEpoch = 5;
constexpr std::uint64_t kHologram = 9;
constexpr double kGainDb = 16.0;

class FrameSeries : public testing::Test {
 protected:
  FrameSeries() {
    plan_.sensor_epoch = kEpoch;
    plan_.tracker_kind = TrackerKind::lg;
    record_.plan = &plan_;
    record_.settled = record_.settings_known = true;
    record_.hologram_id = kHologram;
    record_.gain_db = kGainDb;
    record_.saturated_fraction = 0.5F;
    record_.spot_count = 2;
    record_.spots.resize(8);
    record_.spots[0] = {10.0F, 11.0F, 100.0F, 1.0F};
    record_.spots[1] = {30.0F, 11.0F, 100.0F, 1.0F};
  }

  void begin(int frames, std::vector<Vec2> cells = {}) {
    taker_.begin({frames, kEpoch, kHologram, TrackerKind::lg, kGainDb, 2, std::move(cells)});
  }
  FrameRecord& next() {
    ++record_.frame.frame_id;
    return record_;
  }

  FrameSeriesTaker taker_;
  MeasurementPlan plan_;
  FrameRecord record_;
};

TEST_F(FrameSeries, HoldsTheNextFramesAndNoMore) {
  taker_.add(next());  // before anything is wanted
  begin(2);
  for (int k = 0; k < 3; ++k) {
    record_.spots[0].x = float(10 + k);
    taker_.add(next());
  }
  EXPECT_EQ(taker_.taken(), 2);
  const auto frames = taker_.end();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].frame_id, 2U);
  EXPECT_EQ(frames[1].frame_id, 3U);
  EXPECT_EQ(frames[1].spots.size(), 2U);  // a record has room for more
  EXPECT_EQ(frames[1].spots[0].x, 11.0F);
  EXPECT_EQ(frames[1].saturated_fraction, 0.5F);
  EXPECT_EQ(taker_.taken(), 0);
  taker_.add(next());
  EXPECT_TRUE(taker_.end().empty());
}

TEST_F(FrameSeries, EndsWithWhatCameSoFar) {
  begin(5);
  taker_.add(next());
  EXPECT_EQ(taker_.end().size(), 1U);
}

TEST_F(FrameSeries, AnotherOneBeginsWithNothing) {
  begin(5);
  taker_.add(next());
  begin(1);
  EXPECT_EQ(taker_.taken(), 0);
  taker_.add(next());
  const auto frames = taker_.end();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame_id, 2U);
}

TEST_F(FrameSeries, LeavesOutFramesOfAnythingElse) {
  MeasurementPlan other_sensor, other_tracker;
  other_sensor.sensor_epoch = kEpoch + 1;
  other_sensor.tracker_kind = TrackerKind::lg;
  other_tracker.sensor_epoch = kEpoch;
  other_tracker.tracker_kind = TrackerKind::matched;
  std::vector<FrameRecord> others(7, record_);
  others[0].settled = false;
  others[1].settings_known = false;
  others[2].hologram_id = kHologram + 1;
  others[3].gain_db = kGainDb + 2.0;
  others[4].plan = &other_sensor;
  others[5].plan = &other_tracker;
  others[6].spot_count = 3;  // more than there is room for
  begin(1);
  for (std::size_t k = 0; k < others.size(); ++k) {
    taker_.add(others[k]);
    EXPECT_EQ(taker_.taken(), 0) << k;
  }
  taker_.add(record_);
  EXPECT_EQ(taker_.taken(), 1);
}

/// Cells of half-width 10 px: each spot stands at the one bright pixel of its cell.
class CellSeries : public FrameSeries {
 protected:
  CellSeries() {
    image_.at(12, 9) = 100;
    record_.frame.image = view_of(image_);
  }
  Image<std::uint8_t> image_{40, 20};
  const std::vector<Vec2> cells_{{10, 10}, {30, 10}};
};

TEST_F(CellSeries, MeasuresInThePixelsThatTheImagesThreadLends) {
  EXPECT_FALSE(taker_.wants());
  begin(1, cells_);
  EXPECT_TRUE(taker_.wants());
  taker_.add(next());  // without its pixels
  EXPECT_EQ(taker_.taken(), 0);
  record_.settled = false;
  taker_.take(next());
  EXPECT_EQ(taker_.taken(), 0);
  record_.settled = true;
  taker_.take(next());
  EXPECT_FALSE(taker_.wants());
  const auto frames = taker_.end();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].spots[0].x, 12.0F);
  EXPECT_EQ(frames[0].spots[0].y, 9.0F);
  EXPECT_FALSE(frames[0].spots[1].found());  // dark
  EXPECT_EQ(frames[0].saturated_fraction, 0.5F);
}

TEST_F(CellSeries, TakesNoFrameOfAnotherLattice) {
  begin(1, cells_);
  record_.spot_count = 1;
  taker_.take(next());
  EXPECT_EQ(taker_.taken(), 0);
  EXPECT_TRUE(taker_.wants());
}

/// Whoever looks from another thread sees whole frames, and as many as were counted.
TEST_F(FrameSeries, IsEndedFromAnotherThreadWhileFramesCome) {
  for (int round = 0; round < 50; ++round) {
    begin(1000);
    std::thread publisher([&] {
      for (int k = 0; k < 200; ++k) taker_.add(next());
    });
    const int seen = taker_.taken();
    const auto frames = taker_.end();
    publisher.join();
    EXPECT_GE(int(frames.size()), seen);
    for (std::size_t k = 1; k < frames.size(); ++k) {
      ASSERT_EQ(frames[k].frame_id, frames[k - 1].frame_id + 1);
      ASSERT_EQ(frames[k].spots.size(), 2U);
    }
  }
}

}  // namespace
}  // namespace ovws
