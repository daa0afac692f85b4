/// What the live refinement takes from frames and from references, and when it renders again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "core/optics/noise.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "daemon/ovwsd/fitter/refine_model.hpp"
#include "daemon/ovwsd/fitter/refined_modes.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/library/reference_image.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kEpoch = 5, kHologram = 9, kPlan = 17;

/// A settled frame of 3 x 2 pixels, one byte of padding a row.
class FrameTest : public testing::Test {
 protected:
  FrameTest() {
    plan_.id = kPlan;
    plan_.sensor_epoch = kEpoch;
    record_.plan = &plan_;
    record_.still = record_.settled = true;
    record_.settings_known = true;
    record_.hologram_id = kHologram;
    record_.gain_db = 3.0;
    record_.coefficients = {0.25F, 7.0F};
    record_.sigma_waves = {0.01F, 7.0F};
    record_.mode_count = 1;
    record_.frame.frame_id = 4711;
    record_.frame.image = {reinterpret_cast<const std::byte*>(pixels_.data()), 3, 2, 4,
                           PixelFormat::mono8};
  }

  std::array<std::uint8_t, 8> pixels_{1, 2, 3, 99, 4, 5, 6, 99};
  MeasurementPlan plan_;
  FrameRecord record_;
  FrameTaps taps_;
};

using FrameInboxTest = FrameTest;

TEST_F(FrameInboxTest, CopiesAFrameOnceItIsAskedFor) {
  FrameInbox inbox(taps_, can_be_refined);
  EXPECT_FALSE(taps_.wants_pixels());
  taps_.serve_pixels(record_);
  EXPECT_FALSE(inbox.next(0ms));  // what came before was not asked for
  EXPECT_TRUE(taps_.wants_pixels());
  taps_.serve_pixels(record_);
  EXPECT_FALSE(taps_.wants_pixels());
  pixels_.fill(0);
  const auto frame = inbox.next(0ms);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.frame_id, 4711U);
  EXPECT_EQ(frame->hologram_id, kHologram);
  EXPECT_EQ(frame->plan_id, kPlan);
  EXPECT_EQ(frame->gain_db, 3.0);
  ASSERT_EQ(frame->mode_count, 1);
  EXPECT_EQ(frame->coefficients[0], 0.25F);
  EXPECT_EQ(frame->frame.image.row<std::uint8_t>(1)[2], 6);
  EXPECT_FALSE(inbox.next(0ms));  // each frame once
}

TEST_F(FrameInboxTest, LeavesFramesThatSayNothingForSure) {
  FrameInbox inbox(taps_, can_be_refined);
  EXPECT_FALSE(inbox.next(0ms));
  record_.still = record_.settled = false;
  taps_.serve_pixels(record_);
  record_.still = record_.settled = true;
  record_.settings_known = false;
  taps_.serve_pixels(record_);
  record_.settings_known = true;
  plan_.reference_px = {{1, 1}};
  taps_.serve_pixels(record_);  // a reference, and too few spots
  EXPECT_TRUE(taps_.wants_pixels());
  record_.valid = true;
  taps_.serve_pixels(record_);
  EXPECT_TRUE(inbox.next(0ms));
}

TEST_F(FrameInboxTest, ForgetsWhatWasAskedFor) {
  FrameInbox inbox(taps_, can_be_refined);
  EXPECT_FALSE(inbox.next(0ms));
  inbox.forget();
  EXPECT_FALSE(taps_.wants_pixels());
  EXPECT_FALSE(inbox.next(0ms));
  taps_.serve_pixels(record_);
  inbox.forget();
  EXPECT_FALSE(inbox.next(0ms));
}

using ReferenceImageTest = FrameTest;

TEST_F(ReferenceImageTest, IsTheMeanOfTheReferencesFrames) {
  ImageMean mean;
  EXPECT_TRUE(mean.add(record_));
  pixels_ = {3, 2, 3, 99, 4, 255, 6, 99};
  EXPECT_TRUE(mean.add(record_));
  const auto picture = mean.mean();
  ASSERT_NE(picture, nullptr);
  EXPECT_EQ(picture->frames, 2);
  EXPECT_EQ(picture->gain_db, 3.0);
  EXPECT_EQ(picture->mean_dn.at(0, 0), 2.0F);
  EXPECT_EQ(picture->mean_dn.at(2, 1), 6.0F);
  EXPECT_TRUE(std::isnan(picture->mean_dn.at(1, 1)));  // saturated once
}

TEST_F(ReferenceImageTest, TakesFramesOfOneSizeFormatAndGainOnly) {
  ImageMean mean;
  EXPECT_TRUE(mean.add(record_));
  std::vector<FrameRecord> others(3, record_);
  others[0].gain_db = 4.0;
  others[1].frame.image.width = 2;
  others[2].frame.image.format = PixelFormat::mono16;
  for (const FrameRecord& other : others) EXPECT_FALSE(mean.add(other));
  EXPECT_EQ(mean.mean()->frames, 1);
}

TEST_F(ReferenceImageTest, IsNothingWithoutAFrame) {
  EXPECT_EQ(ImageMean().mean(), nullptr);
}

RefineSetup known_camera() {
  RefineSetup settings;
  settings.electrons_per_dn = 40.0;
  settings.read_noise_e = 3.0;
  settings.black_level_dn = 2.0;
  return settings;
}

TEST(RefineCamera, FollowsGainAndFormat) {
  const RefineCamera plain = refine_camera(known_camera(), PixelFormat::mono8, 0.0);
  EXPECT_EQ(plain.electrons_per_dn, 40.0);
  EXPECT_EQ(plain.black_dn, 2.0);
  EXPECT_EQ(plain.saturated_dn, 255.0);
  EXPECT_NEAR(plain.read_noise_e, std::hypot(3.0, 40.0 / std::sqrt(12.0)), 1e-9);
  const RefineCamera gained = refine_camera(known_camera(), PixelFormat::mono8, 20.0);
  EXPECT_NEAR(gained.electrons_per_dn, 4.0, 1e-9);
  const RefineCamera deep = refine_camera(known_camera(), PixelFormat::mono12, 0.0);
  EXPECT_EQ(deep.electrons_per_dn, 2.5);
  EXPECT_EQ(deep.black_dn, 32.0);
  EXPECT_EQ(deep.saturated_dn, 4095.0);
  EXPECT_NEAR(pixel_noise(plain).constant_dn2, 9.0 / 1600.0 + 1.0 / 12.0, 1e-9);
  EXPECT_NEAR(pixel_noise(plain).per_dn, 1.0 / 40.0, 1e-12);
}

/// Images of the default bench, one electron a DN, and their refinement with the templates of the
/// image before.
class RefineTest : public testing::Test {
 protected:
  static constexpr int kImagePx = 512, kModes = 9;
  static constexpr double kPeakE = 1000.0, kReadNoiseE = 5.0;

  RefineTest() {
    std::iota(modes_j_.begin(), modes_j_.end(), 1);
    model_.emplace(SpotRenderer::make({}, {}, {}, kImagePx, kImagePx, modes_j_, {}).value(), 8);
  }

  /// Refines an image of `waves` of mode 3, with new noise.
  RefinedModes refined(double waves, double peak_e = kPeakE) {
    const std::vector<Mode> shown{{3, waves}};
    Image<float> light = bench_.intensity(shown).value();
    scale(light, peak_e / bench_.peak_of_spots(light, shown));
    Noise noise(++images_, 3);
    Image<std::uint16_t> dn(kImagePx, kImagePx);
    for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
      const double electrons =
          double(noise.poisson(light.pixels[k])) + kReadNoiseE * double(noise.normal());
      dn.pixels[k] = std::uint16_t(std::lround(std::max(0.0, electrons + 50.0)));
    }
    std::vector<double> start(kModes);
    start[2] = waves + 0.01;
    auto found =
        refine(*model_, view_of(dn, PixelFormat::mono16), camera_, {&start, 1}, fixed_, templates_);
    EXPECT_TRUE(found) << (found ? "" : found.error().reason);
    for (int k = 0; found && k < kModes; ++k) {
      EXPECT_NEAR(found->waves[k], k == 2 ? waves : 0.0, 5.0 * found->sigma_waves[k]) << k + 1;
    }
    return found.value_or(RefinedModes{});
  }

  SensorModel bench_ = SensorModel::make({}, {}, {}, kImagePx, kImagePx).value();
  std::vector<int> modes_j_ = std::vector<int>(kModes);
  std::optional<PointModel> model_;
  RefineCamera camera_{1.0, kReadNoiseE, 50.0};
  std::vector<Mode> fixed_;
  std::shared_ptr<const FrameFit> templates_;
  std::uint64_t images_ = 0;
};

TEST_F(RefineTest, UsesTemplatesAgainWhileTheyAreExact) {
  EXPECT_GT(refined(0.2).iterations, 0);
  EXPECT_EQ(refined(0.2).iterations, 0);
  EXPECT_EQ(refined(0.201).iterations, 0);
}

TEST_F(RefineTest, RendersAgainForAnotherWavefrontLightOrCamera) {
  refined(0.2);
  EXPECT_GT(refined(0.25).iterations, 0);
  EXPECT_EQ(refined(0.25).iterations, 0);
  EXPECT_GT(refined(0.25, 0.8 * kPeakE).iterations, 0);
  camera_.read_noise_e = 6.0;
  EXPECT_GT(refined(0.25, 0.8 * kPeakE).iterations, 0);
  EXPECT_EQ(refined(0.25, 0.8 * kPeakE).iterations, 0);
  fixed_ = {{20, 1e-6}};
  EXPECT_GT(refined(0.25, 0.8 * kPeakE).iterations, 0);
}

TEST(RefinedModes, SaysWhyItCannotBeBelieved) {
  const RefineCamera camera{1.0, 5.0};
  RefinedModes modes{{0.1}, {0.001}, 1.0, 500.0, 0.0, 5};
  EXPECT_FALSE(modes.doubt(camera).has_value());
  modes.peak_e = 4.0;
  EXPECT_NE(modes.doubt(camera)->find("read noise"), std::string::npos);
  modes.peak_e = 500.0;
  modes.sigma_waves = {0.2};
  EXPECT_NE(modes.doubt(camera)->find("0.20 wave"), std::string::npos);
  modes.sigma_waves = {0.001};
  modes.chi2_per_pixel = 9.0;
  EXPECT_NE(modes.doubt(camera)->find("9.0"), std::string::npos);
  modes.higher_waves = 0.01;
  EXPECT_FALSE(modes.doubt(camera).has_value()) << "higher modes explain it";
  modes.chi2_per_pixel = std::nan("");
  EXPECT_TRUE(modes.doubt(camera));
}

}  // namespace
}  // namespace ovws
