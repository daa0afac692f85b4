/// Properties that every tracker must have, for each charge that it supports.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/tracking/tracker.hpp"
#include "tests/support/alloc_guard.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::kLambdaD;
using test::SpotImage;

struct TrackerCase {
  TrackerKind kind;
  int charge;
  double bound_px;  ///< largest error on a noise-free 12-bit spot
};

std::string tracker_case_name(const testing::TestParamInfo<TrackerCase>& info) {
  const int charge = info.param.charge;
  return std::string(tracker_name(info.param.kind)) + (charge < 0 ? "_minus" : "_") +
         std::to_string(std::abs(charge));
}

class EveryTracker : public testing::TestWithParam<TrackerCase> {
 protected:
  EveryTracker()
      : tracker_(make_tracker({GetParam().kind, 0.4}, {GetParam().charge, kLambdaD}).value()),
        scratch_(tracker_->make_scratch()) {}

  SpotImage spot_at(Vec2 at, double peak_dn = 200.0) const {
    SpotImage picture;
    picture.add(GetParam().charge, at, peak_dn);
    return picture;
  }
  SpotFix track(const Image<std::uint8_t>& image, Vec2 start) {
    return tracker_->track(view_of(image), start, scratch_);
  }
  void expect_lost(const Image<std::uint8_t>& image, Vec2 start) {
    const SpotFix fix = track(image, start);
    EXPECT_TRUE(std::isnan(fix.x) && std::isnan(fix.y)) << fix.x << ", " << fix.y;
    EXPECT_EQ(fix.quality, 0.0F);
    EXPECT_FALSE(fix.found());
  }

  std::unique_ptr<const SpotTracker> tracker_;
  TrackScratch scratch_;
};

TEST_P(EveryTracker, RecoversSubPixelPositionsOfANoiseFreeSpot) {
  for (const Vec2 truth : {Vec2{62.0, 58.0}, Vec2{62.5, 58.5}, Vec2{62.25, 58.7}, Vec2{61.9, 58.1},
                           Vec2{62.49, 57.51}}) {
    const auto image = spot_at(truth).mono16(16.0, 4095);
    const SpotFix fix = tracker_->track(view_of(image, PixelFormat::mono12), {62, 58}, scratch_);
    EXPECT_NEAR(fix.x, truth.x, GetParam().bound_px);
    EXPECT_NEAR(fix.y, truth.y, GetParam().bound_px);
    EXPECT_GT(fix.quality, 0.8F);
    EXPECT_LE(fix.quality, 1.0F);
  }
}

TEST_P(EveryTracker, KeepsXAndYApartAndTheirSigns) {
  for (const Vec2 move : {Vec2{2.3, 0.0}, Vec2{-2.3, 0.0}, Vec2{0.0, 1.7}, Vec2{0.0, -1.7}}) {
    const Vec2 truth = Vec2{64, 50} + move;
    const SpotFix fix = track(spot_at(truth).mono8(), {64, 50});
    // The plain centroid's region stays at its start, so that it cuts the spot's wings.
    const double slack = GetParam().kind == TrackerKind::centroid ? 0.15 : 0.02;
    EXPECT_NEAR(fix.x, truth.x, slack);
    EXPECT_NEAR(fix.y, truth.y, slack);
  }
}

TEST_P(EveryTracker, FollowsTheShiftThatATiltOverTheApertureMakes) {
  SpotImage picture;
  const Vec2 move{1.8, -2.6};
  picture.add(GetParam().charge, {60, 60}, 200.0, test::tilt(move, picture.lambda_d_px));
  const SpotFix fix = track(picture.mono8(), Vec2{60, 60} + move);
  EXPECT_NEAR(fix.x, 61.8, 0.02);
  EXPECT_NEAR(fix.y, 57.4, 0.02);
}

TEST_P(EveryTracker, GivesTheSameFor8And16BitPixels) {
  const SpotImage picture = spot_at({61.3, 57.8});
  const auto wide = picture.mono16(1.0, 255);
  const SpotFix a = track(picture.mono8(), {61, 58});
  const SpotFix b = tracker_->track(view_of(wide, PixelFormat::mono16), {61, 58}, scratch_);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.peak, b.peak);
  EXPECT_EQ(a.quality, b.quality);
}

TEST_P(EveryTracker, ReadsRowsByTheirStride) {
  const auto image = spot_at({61.3, 57.8}).mono8();
  Image<std::uint8_t> padded(image.width + 13, image.height, 255);
  for (int y = 0; y < image.height; ++y) {
    std::copy(image.row(y), image.row(y) + image.width, padded.row(y));
  }
  ImageView view = view_of(padded);
  view.width = image.width;
  const SpotFix a = track(image, {61, 58});
  const SpotFix b = tracker_->track(view, {61, 58}, scratch_);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.peak, b.peak);
}

TEST_P(EveryTracker, ReportsTheBrightestPixelOfItsSpot) {
  SpotImage picture = spot_at({60, 60}, 180.0);
  EXPECT_EQ(track(picture.mono8(), {60, 60}).peak, 180.0F);
  picture.light.at(100, 60) = 250.0F;  // outside the spot
  EXPECT_EQ(track(picture.mono8(), {60, 60}).peak, 180.0F);
}

TEST_P(EveryTracker, ReportsTheBrightestPixelOfALostSpotToo) {
  const Image<std::uint8_t> saturated(128, 120, 255);
  EXPECT_EQ(track(saturated, {60, 60}).peak, 255.0F);
}

TEST_P(EveryTracker, FollowsASpotThatSaturates) {
  SpotImage picture = spot_at({60.4, 59.7}, 330.0);
  const SpotFix fix = track(picture.mono8(), {60, 60});
  EXPECT_NEAR(fix.x, 60.4, 0.05);
  EXPECT_NEAR(fix.y, 59.7, 0.05);
  EXPECT_EQ(fix.peak, 255.0F);
}

TEST_P(EveryTracker, LosesASpotAtTheImagesEdge) {
  for (const Vec2 at : {Vec2{4, 60}, Vec2{123, 60}, Vec2{64, 4}, Vec2{64, 115}, Vec2{2, 2}}) {
    expect_lost(spot_at(at).mono8(), at);
  }
}

TEST_P(EveryTracker, LosesAStartThatIsNotInTheImage) {
  const auto image = spot_at({64, 60}).mono8();
  const double nan = std::nan("");
  for (const Vec2 start : {Vec2{-1, 60}, Vec2{64, 1e9}, Vec2{-1e300, 0}, Vec2{nan, 60},
                           Vec2{64, nan}, Vec2{128, 60}, Vec2{64, INFINITY}}) {
    expect_lost(image, start);
  }
}

/// Every tracker reads more than 26 pixels beside the start: up to the spot's dark ring.
TEST_P(EveryTracker, WorksWhereTheWindowIsClippedAtTheEdge) {
  const auto image = spot_at({26.2, 27.1}).mono8();
  const SpotFix fix = track(image, {26, 27});
  EXPECT_NEAR(fix.x, 26.2, 0.03);
  EXPECT_NEAR(fix.y, 27.1, 0.03);
}

/// All trackers but the plain centroid, whose disc stays at the start.
class EveryTrackerThatMoves : public EveryTracker {};

/// Also if the tracker must read other pixels than those around the start.
TEST_P(EveryTrackerThatMoves, FindsTheSameFromAFarStart) {
  const auto image = spot_at({62.3, 58.6}).mono16(16.0, 4095);
  const ImageView view = view_of(image, PixelFormat::mono12);
  const SpotFix near = tracker_->track(view, {62, 59}, scratch_);
  for (const Vec2 off : {Vec2{6, 0}, Vec2{-5, 3}, Vec2{0, -6}, Vec2{4, 4}}) {
    const SpotFix fix = tracker_->track(view, Vec2{62.3, 58.6} + off, scratch_);
    EXPECT_NEAR(fix.x, near.x, 2e-3);
    EXPECT_NEAR(fix.y, near.y, 2e-3);
  }
}

TEST_P(EveryTracker, LosesWhatIsFurtherThanOneLambdaOverD) {
  const auto image = spot_at({64, 60}).mono8();
  for (const Vec2 start : {Vec2{64 + 14, 60}, Vec2{64, 60 - 14}, Vec2{64 - 30, 60 + 10}}) {
    expect_lost(image, start);
  }
}

TEST_P(EveryTracker, LosesBlackSaturatedAndFlatImages) {
  for (const int level : {0, 1, 100, 255}) {
    expect_lost(Image<std::uint8_t>(128, 120, std::uint8_t(level)), {64, 60});
  }
  Image<std::uint8_t> one_pixel(128, 120, 0);
  one_pixel.at(64, 60) = 255;
  expect_lost(one_pixel, {64, 60});
  Image<std::uint8_t> one_hole(128, 120, 255);
  one_hole.at(64, 60) = 0;
  expect_lost(one_hole, {64, 60});
}

TEST_P(EveryTracker, LosesAGradientAndAnEdge) {
  Image<std::uint8_t> gradient(128, 120), edge(128, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 128; ++x) {
      gradient.at(x, y) = std::uint8_t(x + y);
      edge.at(x, y) = x < 64 ? 10 : 200;
    }
  }
  for (int k = 0; k < 12; ++k) {
    expect_lost(gradient, {58.0 + k, 60});
    expect_lost(edge, {58.0 + k, 60});
  }
}

TEST_P(EveryTracker, FindsNothingInNoise) {
  const int images = GetParam().kind == TrackerKind::lg_contour ? 2 : 60;
  for (int k = 0; k < images; ++k) {
    SpotImage dark;
    dark.pedestal_dn = 5.0 * (k % 7);
    const auto image = dark.noisy8(0.5 + k % 9, unsigned(k));
    for (int i = 0; i < 6; ++i) expect_lost(image, {40.0 + 9 * i, 45.0 + 7 * i});
  }
}

TEST_P(EveryTracker, IsTheSameInNoise) {
  SpotImage picture = spot_at({61.3, 57.8}, 100.0);
  picture.pedestal_dn = 8.0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const SpotFix fix = track(picture.noisy8(2.0, seed), {61, 58});
    // The pedestal biases the plain centroid towards its start, which is not judged here.
    const double slack = GetParam().kind == TrackerKind::centroid ? 0.5 : 0.2;
    EXPECT_NEAR(fix.x, 61.3, slack);
    EXPECT_NEAR(fix.y, 57.8, slack);
  }
}

/// All trackers but the oracle, which may allocate.
class EveryFramePathTracker : public EveryTracker {};

TEST_P(EveryFramePathTracker, DoesNotAllocate) {
  const auto image = spot_at({61.3, 57.8}).mono8();
  const Image<std::uint8_t> black(128, 120, 0);
  const test::AllocGuard guard;
  const SpotFix found = tracker_->track(view_of(image), {61, 58}, scratch_);
  const SpotFix lost = tracker_->track(view_of(black), {61, 58}, scratch_);
  const auto allocations = guard.allocations();
  EXPECT_EQ(allocations, 0U);
  EXPECT_TRUE(found.found());
  EXPECT_FALSE(lost.found());
}

const std::vector<TrackerCase> kMoving = {
    {TrackerKind::lg, 1, 0.002},       {TrackerKind::lg, -1, 0.002},
    {TrackerKind::lg, 2, 0.004},       {TrackerKind::lg, -2, 0.004},
    {TrackerKind::lg, 0, 0.002},       {TrackerKind::thresholded, 0, 0.005},
    {TrackerKind::weighted, 0, 0.002},
};
const std::vector<TrackerCase> kCentroid = {{TrackerKind::centroid, 0, 0.05}};
const std::vector<TrackerCase> kOracle = {{TrackerKind::lg_contour, 1, 0.002},
                                          {TrackerKind::lg_contour, 0, 0.002}};
using testing::ValuesIn;

INSTANTIATE_TEST_SUITE_P(Moving, EveryTracker, ValuesIn(kMoving), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Centroid, EveryTracker, ValuesIn(kCentroid), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Oracle, EveryTracker, ValuesIn(kOracle), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Moving, EveryTrackerThatMoves, ValuesIn(kMoving), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Oracle, EveryTrackerThatMoves, ValuesIn(kOracle), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Moving, EveryFramePathTracker, ValuesIn(kMoving), tracker_case_name);
INSTANTIATE_TEST_SUITE_P(Centroid, EveryFramePathTracker, ValuesIn(kCentroid), tracker_case_name);

TEST(MakeTracker, RefusesAKernelOutOfRange) {
  for (const double radius : {0.0, 0.09, 2.01, -1.0, std::nan("")}) {
    const auto tracker = make_tracker({TrackerKind::lg, radius}, {1, kLambdaD});
    ASSERT_FALSE(tracker.has_value()) << radius;
    EXPECT_EQ(tracker.error().code, Errc::invalid);
    EXPECT_EQ(tracker.error().field, "tracking.kernel_radius");
  }
  EXPECT_TRUE(make_tracker({TrackerKind::lg, 0.1}, {1, kLambdaD}).has_value());
  EXPECT_TRUE(make_tracker({TrackerKind::lg, 2.0}, {1, kLambdaD}).has_value());
}

TEST(MakeTracker, RefusesBrightSpotTrackersForAVortex) {
  for (const auto kind : {TrackerKind::centroid, TrackerKind::thresholded, TrackerKind::weighted}) {
    const auto tracker = make_tracker({kind, 0.4}, {1, kLambdaD});
    ASSERT_FALSE(tracker.has_value());
    EXPECT_EQ(tracker.error().field, "tracking.tracker");
    EXPECT_TRUE(make_tracker({kind, 0.4}, {0, kLambdaD}).has_value());
  }
}

TEST(MakeTracker, RefusesSpotsThatNoCameraCouldShow) {
  for (const double lambda_d : {0.0, 3.4, 201.0, std::nan("")}) {
    EXPECT_FALSE(make_tracker({TrackerKind::lg, 0.4}, {1, lambda_d}).has_value()) << lambda_d;
  }
  EXPECT_FALSE(make_tracker({TrackerKind::lg, 0.4}, {9, kLambdaD}).has_value());
}

TEST(MakeTracker, TracksSpotsOfEverySize) {
  for (const double lambda_d : {3.5, 4.0, 5.5, 8.0, 25.0}) {
    for (const int charge : {0, 1}) {
      const auto tracker = make_tracker({TrackerKind::lg, 0.4}, {charge, lambda_d}).value();
      auto scratch = tracker->make_scratch();
      SpotImage picture(160, 160);
      picture.lambda_d_px = lambda_d;
      picture.add(charge, {80.3, 79.6}, 200.0);
      const auto image = picture.mono8();
      const SpotFix fix = tracker->track(view_of(image), {80, 80}, scratch);
      EXPECT_NEAR(fix.x, 80.3, 0.03) << lambda_d << " charge " << charge;
      EXPECT_NEAR(fix.y, 79.6, 0.03) << lambda_d << " charge " << charge;
    }
  }
}

}  // namespace
}  // namespace ovws
