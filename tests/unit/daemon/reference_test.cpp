#include "daemon/ovwsd/sensor/spot_average.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr int kSpots = 3;
constexpr double kMaxMotionPx = 0.63;

class ReferenceTest : public testing::Test {
 protected:
  ReferenceTest() {
    record_.spot_count = kSpots;
    record_.spots.resize(8);
  }

  /// The average of so many frames in which each spot is found at its peak, DN of Mono8.
  SpotAverage averaged(const std::vector<std::vector<float>>& peaks_dn) {
    SpotAverager averager(int(peaks_dn.size()), kSpots);
    for (const auto& frame : peaks_dn) {
      for (std::size_t i = 0; i < kSpots; ++i) record_.spots[i] = {1.0F, 1.0F, frame[i], 1.0F};
      averager.add(record_);
    }
    return averager.average();
  }

  /// The average of so many frames of three spots about different places; `moved` of a frame's
  /// number is added to each, in the second spot by half, and noise.
  template <class Moved>
  SpotAverage moving(int frames, double noise_px, const Moved& moved) {
    std::normal_distribution<double> noise(0.0, noise_px);
    SpotAverager averager(frames, kSpots);
    for (int k = 0; k < frames; ++k) {
      for (std::size_t i = 0; i < kSpots; ++i) {
        const double own = i == 1 ? 0.5 : 1.0;
        record_.spots[i] = {float(100.0 * double(i) + own * moved(k) + noise(random_)),
                            float(50.0 + noise(random_)), 100.0F, 1.0F};
      }
      averager.add(record_);
    }
    return averager.average();
  }

  std::mt19937 random_{7};
  FrameRecord record_;
};

TEST_F(ReferenceTest, MeanAndStandardErrorAreThoseOfTheFrames) {
  constexpr int kFrames = 10000;
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 0.5F);
  SpotAverager averager(kFrames, kSpots);
  for (int i = 0; i < kFrames; ++i) {
    record_.spots[1] = {100.0F + noise(random), 50.0F + 2.0F * noise(random), 100.0F, 1.0F};
    EXPECT_TRUE(averager.add(record_));
  }
  const SpotAverage average = averager.average();
  EXPECT_EQ(average.frames, kFrames);
  EXPECT_EQ(average.found, (std::vector<int>{0, kFrames, 0}));
  EXPECT_NEAR(average.mean_px[1].x, 100.0, 0.02);
  EXPECT_NEAR(average.mean_px[1].y, 50.0, 0.04);
  EXPECT_NEAR(average.standard_error_px[1].x, 0.005, 0.0005);
  EXPECT_NEAR(average.standard_error_px[1].y, 0.010, 0.001);
}

TEST_F(ReferenceTest, AFrameOfAnotherNumberOfSpotsIsNotUsed) {
  SpotAverager averager(1, kSpots + 1);
  EXPECT_FALSE(averager.add(record_));
  EXPECT_EQ(averager.average().frames, 0);
}

TEST_F(ReferenceTest, OneSaturatedSpotInATenthOfTheFramesIsNamedAndBorne) {
  std::vector<std::vector<float>> peaks(10, {200.0F, 254.0F, 90.0F});
  peaks[4][1] = 255.0F;
  const auto average = averaged(peaks);
  EXPECT_EQ(average.saturated, (std::vector<int>{0, 1, 0}));
  EXPECT_TRUE(check_average(average, kMaxMotionPx));
  EXPECT_EQ(saturated_spots(average), std::vector<int>{1});
}

TEST_F(ReferenceTest, SpotsThatAreSaturatedAreRefusedEvenIfTheyAreFound) {
  const auto average = averaged(std::vector<std::vector<float>>(10, {200.0F, 255.0F, 90.0F}));
  const auto checked = check_average(average, kMaxMotionPx);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().field, "camera.exposure_us");
  EXPECT_NE(checked.error().reason.find("33 % of the spots are saturated"), std::string::npos);
}

TEST_F(ReferenceTest, FullScaleIsThatOfThePixelFormat) {
  record_.frame.image.format = PixelFormat::mono12;
  EXPECT_TRUE(saturated_spots(averaged({{300.0F, 4094.0F, 90.0F}})).empty());
  EXPECT_EQ(saturated_spots(averaged({{300.0F, 4095.0F, 90.0F}})), std::vector<int>{1});
}

TEST_F(ReferenceTest, ABenchThatMovesMeanwhileIsRefusedWithTheFigures) {
  const auto step = moving(100, 0.01, [](int k) { return k < 50 ? 0.0 : 3.0; });
  const double rms_step = 3.0 * std::sqrt(2.25 / 6.0);  // of spots that move by 1, 1/2 and 1, in x
  EXPECT_NEAR(step.drift_px, rms_step, 0.01);
  EXPECT_NEAR(step.scatter_px, 0.5 * rms_step, 0.01);
  const auto checked = check_average(step, kMaxMotionPx);
  ASSERT_FALSE(checked);
  for (const char* figure : {"1.84 px", "0.92 px", "0.63 px"}) {
    EXPECT_NE(checked.error().reason.find(figure), std::string::npos) << checked.error().reason;
  }
  // A bump that is over again has no drift.
  const auto bump = moving(100, 0.01, [](int k) { return k >= 40 && k < 60 ? 3.0 : 0.0; });
  EXPECT_LT(bump.drift_px, 0.1);
  EXPECT_FALSE(check_average(bump, kMaxMotionPx));
  EXPECT_FALSE(check_average(moving(100, 0.3, [](int k) { return 0.03 * k; }), kMaxMotionPx));
}

TEST_F(ReferenceTest, NoiseIsNoMotionHoweverStrong) {
  for (const double noise_px : {0.01, 0.5, 3.0}) {
    for (const int frames : {1, 2, 5, 100}) {
      const auto still = moving(frames, noise_px, [](int) { return 0.0; });
      EXPECT_TRUE(check_average(still, kMaxMotionPx)) << noise_px << " px, " << frames;
      if (frames < 100) continue;
      EXPECT_NEAR(still.noise_px, noise_px, 0.15 * noise_px);
    }
  }
  // All spots shake together, from frame to frame.
  std::normal_distribution<double> shake(0.0, 2.0);
  EXPECT_TRUE(check_average(moving(100, 0.01, [&](int) { return shake(random_); }), kMaxMotionPx));
}

/// 19 spots and 18 modes.
class ReferenceSpotsTest : public testing::Test {
 protected:
  ReferenceSpotsTest() {
    const SensorConfig sensor;
    const Lattice lattice = make_lattice(sensor, SlmGeometry{}).value();
    modes_.modes_j.resize(18);
    std::iota(modes_.modes_j.begin(), modes_.modes_j.end(), 1);
    modes_.slopes = slope_matrix(lattice, sensor, modes_.modes_j, kVortexTilt, 1928.3);
    for (const Subaperture& one : lattice.subapertures) {
      model_px_.push_back(Vec2{256.0, 256.0} + 0.4 * one.centre_px);
    }
    average_.frames = 100;
    average_.found.assign(lattice.subapertures.size(), 100);
  }

  ModeOperator modes_;
  std::vector<Vec2> model_px_;
  SpotAverage average_;
};

TEST_F(ReferenceSpotsTest, SpotsThatComeAndGoAreWeakAndThoseThatAreLostAreLeftOut) {
  average_.found[0] = 85;
  average_.found[7] = 0;
  average_.found[11] = 49;
  const auto spots = judge_spots(average_, modes_);
  ASSERT_TRUE(spots) << spots.error().reason;
  EXPECT_EQ(spots->weak, std::vector<int>{0});
  EXPECT_EQ(spots->lost, (std::vector<int>{7, 11}));
  EXPECT_FALSE(spots->weak_modes_j.empty());
  EXPECT_LT(spots->weak_modes_j.size(), 9U);
}

TEST_F(ReferenceSpotsTest, IsRefusedOnlyWhereAModeIsNotDetermined) {
  EXPECT_TRUE(judge_spots(average_, modes_)->weak_modes_j.empty());
  for (const int i : {0, 1, 2, 3, 6, 7, 11, 12}) average_.found[std::size_t(i)] = 10;
  const auto refused = judge_spots(average_, modes_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::refused);
  EXPECT_NE(refused.error().reason.find("spots 0, 1, 2, 3, 6, 7, 11, 12"), std::string::npos)
      << refused.error().reason;
  EXPECT_NE(refused.error().reason.find("the modes j = "), std::string::npos);
}

TEST_F(ReferenceSpotsTest, ALostSpotIsExpectedWhereTheOthersSayAndHasNoReference) {
  Reference reference;
  for (const Vec2 at : model_px_) {  // moved, turned and magnified
    reference.positions_px.push_back(Vec2{3.0, -2.0} + 1.01 * at + 0.02 * Vec2{-at.y, at.x});
  }
  const std::vector<Vec2> truth = reference.positions_px;
  reference.standard_error_px.assign(truth.size(), Vec2{0.01, 0.01});
  reference.positions_px[7] = {};
  place_lost({7}, model_px_, reference);
  EXPECT_NEAR(norm(reference.positions_px[7] - truth[7]), 0.0, 1e-3);
  const std::vector<Vec2> known = known_positions(reference);
  EXPECT_TRUE(std::isnan(known[7].x));
  EXPECT_EQ(known[8].x, truth[8].x);
}

}  // namespace
}  // namespace ovws
