/// camera.auto_exposure on the simulated bench, and its judgement of single images.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include "daemon/ovwsd/procedures/exposure_look.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "tests/support/simulated_bench.hpp"

namespace ovws {
namespace {

using test::SimulatedBench;
using test::small_daemon_config;
using test::small_twin_config;

Result<AutoExposureReport> expose_on(SimulatedBench& bench, const AutoExposure& asked = {}) {
  AutoExposureReport report;
  const auto run = bench.run("camera.auto_exposure", [&](Bench& on) -> Result<nlohmann::json> {
    auto found = set_exposure(on, asked);
    if (!found) return fail(found.error());
    report = *found;
    return nlohmann::json{};
  });
  if (!run) return fail(run.error());
  return report;
}

struct Bright {
  double light = 1.0;  ///< times the usual laser's power
  double exposure_us = 2000.0;
  double gain_db = 0.0;
  double target = 0.7;
};

class AutoExposureFrom : public testing::TestWithParam<Bright> {};

TEST_P(AutoExposureFrom, EndsAtTheTarget) {
  const Bright& begin = GetParam();
  auto daemon = small_daemon_config();
  auto twin = small_twin_config();
  daemon.camera.settings.exposure_us = begin.exposure_us;
  daemon.camera.settings.gain_db = begin.gain_db;
  twin.truth.peak_electrons *= begin.light;
  SimulatedBench bench(daemon, twin);
  const auto found = expose_on(bench, {begin.target, std::nullopt});
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_NEAR(found->brightest, begin.target, 0.05 * begin.target)
      << found->exposure_us << " us, look " << found->looks;
  EXPECT_LT(found->saturated_pixels, 60) << "of the zeroth order";
  EXPECT_LE(found->looks, 7);
  const CameraSnapshot camera = bench.camera();
  EXPECT_EQ(camera.settings.exposure_us, found->exposure_us);
  EXPECT_EQ(camera.asked.exposure_us, found->exposure_us) << "config.save keeps it";
  EXPECT_EQ(camera.settings.gain_db, found->gain_db);
  EXPECT_LE(found->gain_db, begin.gain_db);
}
INSTANTIATE_TEST_SUITE_P(Benches, AutoExposureFrom,
                         testing::Values(Bright{2.0, 2000.0}, Bright{10.0, 2000.0},
                                         Bright{5.0, 20.0}, Bright{2.0, 2500.0, 12.0},
                                         Bright{10.0, 2000.0, 30.0}, Bright{1.0, 10.0, 0.0, 0.3}));

TEST(AutoExposureJob, LeavesNoSpotSaturated) {
  auto twin = small_twin_config();
  twin.light.shape = twin::LightShape::gaussian;  // the middle spot is half as bright again
  twin.light.diameter_px = 1.5 * small_daemon_config().sensor.pupil_diameter_px;
  SimulatedBench bench(small_daemon_config(), twin);
  const auto found = expose_on(bench);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_GT(found->brightest, 0.5);
  int saturated = -1;
  const auto run = bench.run("reference.take", [&](Bench& on) -> Result<nlohmann::json> {
    const auto average = on.spots(10);
    if (!average) return fail(average.error());
    saturated = int(saturated_spots(*average).size());
    return nlohmann::json{};
  });
  ASSERT_TRUE(run) << run.error().reason;
  EXPECT_EQ(saturated, 0);
}

TEST(AutoExposureJob, JudgesTheGratingsSpot) {
  auto twin = small_twin_config();
  twin.truth.peak_electrons *= 0.1;
  SimulatedBench bench(small_daemon_config(), twin);
  ASSERT_TRUE(bench.edit(show_pattern(HologramKind::grating)));
  const auto found = expose_on(bench);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_NEAR(found->brightest, 0.7, 0.035);
  EXPECT_LT(found->saturated_pixels, 30) << "of the zeroth order";
}

TEST(AutoExposureJob, UsesNoLongerExposureThanAsked) {
  auto twin = small_twin_config();
  twin.truth.peak_electrons *= 2.0;
  SimulatedBench bench(small_daemon_config(), twin);
  const auto free = expose_on(bench);
  ASSERT_TRUE(free) << free.error().reason;
  const auto refused = expose_on(bench, {0.7, 0.5 * free->exposure_us});
  ASSERT_FALSE(refused) << "at the target with a longer exposure";
  EXPECT_EQ(refused.error().field, "max_exposure_us");
  EXPECT_EQ(bench.camera().settings.exposure_us, free->exposure_us);
  const auto nearest = expose_on(bench, {0.7, 0.85 * free->exposure_us});
  ASSERT_TRUE(nearest) << nearest.error().reason;
  EXPECT_NEAR(nearest->brightest, 0.6, 0.06) << "the nearest that is allowed";
  const auto lower = expose_on(bench, {0.3, 0.5 * free->exposure_us});
  ASSERT_TRUE(lower) << lower.error().reason;
  EXPECT_LE(lower->exposure_us, 0.501 * free->exposure_us);
}

/// A bench on which the job fails with a reason, and leaves the camera as it was.
struct Hopeless {
  const char* name;
  double light;
  double full_well_e;
  AutoExposure asked;
  const char* field;
  const char* reason;
};

class AutoExposureFails : public testing::TestWithParam<Hopeless> {};

TEST_P(AutoExposureFails, WithAReasonAndRestoresTheCamera) {
  const Hopeless& bad = GetParam();
  auto daemon = small_daemon_config();
  auto twin = small_twin_config();
  daemon.camera.settings.exposure_us = 150.0;
  daemon.camera.settings.gain_db = 3.0;
  twin.truth.peak_electrons *= bad.light;
  SimulatedBench bench(daemon, twin);
  const auto found = expose_on(bench, bad.asked);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().field, bad.field);
  EXPECT_NE(found.error().reason.find(bad.reason), std::string::npos) << found.error().reason;
  EXPECT_EQ(bench.camera().settings.exposure_us, 150.0);
  EXPECT_EQ(bench.camera().settings.gain_db, 3.0);
}
INSTANTIATE_TEST_SUITE_P(
    Benches, AutoExposureFails,
    testing::Values(Hopeless{"no light", 0.0, 0.0, {}, "camera.frame_rate_hz", "laser is on"},
                    Hopeless{"too dark", 0.1, 0.0, {}, "camera.frame_rate_hz", "too dark"},
                    Hopeless{"short limit", 1.0, 0.0, {0.7, 200.0}, "max_exposure_us", "too dark"},
                    Hopeless{"too bright", 1e4, 0.0, {}, "camera.exposure_us", "neutral-density"}),
    [](const auto& of) {
      std::string name = of.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(AutoExposureJob, RestoresTheCameraWhenItIsCancelled) {
  auto twin = small_twin_config();
  twin.truth.peak_electrons *= 100.0;
  std::atomic<int> applied{0};
  SimulatedBench bench(small_daemon_config(), twin);
  bench.optics().before_apply([&] {
    if (++applied == 1) bench.cancel();
  });
  const auto found = expose_on(bench);
  ASSERT_FALSE(found);
  EXPECT_EQ(applied, 2) << "another exposure, and the previous one";
  EXPECT_EQ(bench.camera().settings.exposure_us, 2000.0);
}

/// Black level 2, and spots of 5 x 5 pixels.
Image<float> image_with(int spots, float level) {
  Image<float> image(64, 64, 2.0F);
  for (int k = 0; k < spots; ++k) {
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        image.at(8 + 12 * (k % 4) + x, 8 + 12 * (k / 4) + y) =
            2.0F + level * std::exp(-0.5F * float(x * x + y * y) / 2.0F);
      }
    }
  }
  return image;
}

TEST(ExposureLook, IsNotOfHotPixels) {
  const CameraSettings settings;
  Image<float> image = image_with(7, 100.0F);
  for (int k = 0; k < 40; ++k) image.at(3 * (k % 8) + 1, 62 - 3 * (k / 8)) = NAN;
  const auto look = judge_exposure(image, {7, 4.0, 6.0}, settings);
  EXPECT_NEAR(look.brightest, 102.0, 1.0);
  EXPECT_NEAR(look.dark, 2.0, 0.1);
  EXPECT_EQ(look.saturated_pixels, 40);
  EXPECT_TRUE(look.lit);
  EXPECT_TRUE(judge_exposure(image, {7, 1.0, 1.5}, settings).saturated());
}

TEST(ExposureLook, IsNotOfABrightZerothOrder) {
  Image<float> image = image_with(7, 100.0F);
  for (int k = 0; k < 9; ++k) image.at(56 + k % 3, 56 + k / 3) = NAN;
  const auto look = judge_exposure(image, {7, 4.0, 6.0}, {});
  EXPECT_NEAR(look.brightest, 102.0, 1.0);
  EXPECT_EQ(look.saturated_pixels, 9);
}

TEST(ExposureLook, IsNotOfSideLobesThatAreBrighterThanSpots) {
  Image<float> image = image_with(7, 60.0F);
  for (int k = 0; k < 9; ++k) image.at(56 + k % 3, 44 + k / 3) = NAN;
  const float lobes[] = {240.0F, 200.0F, 160.0F, 120.0F, 95.0F};
  for (int k = 0; k < 5; ++k) {
    image.at(8 + 10 * k, 56) = lobes[k];
    image.at(9 + 10 * k, 56) = 0.8F * lobes[k];
  }
  EXPECT_NEAR(judge_exposure(image, {7, 4.0, 6.0}, {}).brightest, 62.0, 1.0);
}

TEST(ExposureLook, IsOfTheTrackedSpotsWhateverElseIsBright) {
  Image<float> image = image_with(7, 60.0F);
  for (int k = 0; k < 12; ++k) image.at(4 + 5 * k, 58) = image.at(5 + 5 * k, 58) = 180.0F;
  ExpectedSpots expected{7, 4.0, 6.0};
  for (int k = 0; k < 7; ++k) expected.found_px.push_back({8.0 + 12 * (k % 4), 8.0 + 12 * (k / 4)});
  const auto look = judge_exposure(image, expected, {});
  EXPECT_NEAR(look.brightest, 62.0, 1.0);
  ASSERT_TRUE(look.top);
  EXPECT_NEAR(*look.top, 62.0, 1.0);
  image.at(9, 9) = NAN;
  EXPECT_NEAR(judge_exposure(image, expected, {}).top.value(), 62.0, 1.0) << "a stuck pixel";
  for (int k = 0; k < 4; ++k) image.at(8 + k % 2, 8 + k / 2) = NAN;
  const auto clipped = judge_exposure(image, expected, {});
  EXPECT_NEAR(clipped.brightest, 62.0, 1.0);
  EXPECT_TRUE(clipped.saturated()) << "one spot lies under another order";
  expected.found_px.resize(3);
  EXPECT_FALSE(judge_exposure(image, expected, {}).top) << "too few are found";
}

TEST(ExposureLook, IsOfTheSpotsThatAreInsideTheImage) {
  EXPECT_NEAR(judge_exposure(image_with(7, 60.0F), {12, 4.0, 6.0}, {}).brightest, 62.0, 1.0);
  EXPECT_NEAR(judge_exposure(image_with(4, 60.0F), {7, 4.0, 6.0}, {}).brightest, 62.0, 1.0);
}

TEST(ExposureLook, IsOfTheBrightSpotsOfANarrowBeam) {
  Image<float> image = image_with(19, 1.0F);
  for (int k = 0; k < 19; ++k) {  // a Gaussian beam whose 1/e^2 diameter is that of the pupil
    const float level = k == 0 ? 200.0F : k < 7 ? 145.0F : k < 13 ? 76.0F : 55.0F;
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        float& dn = image.at(8 + 12 * (k % 4) + x, 8 + 12 * (k / 4) + y);
        dn = 2.0F + level * (dn - 2.0F);
      }
    }
  }
  EXPECT_NEAR(judge_exposure(image, {19, 4.0, 6.0}, {}).brightest, 147.0, 1.0);
}

TEST(ExposureLook, OfOneSpotIsNotOfItsRing) {
  Image<float> image = image_with(2, 150.0F);
  image.at(8, 8) = NAN;
  EXPECT_TRUE(judge_exposure(image, {1, 4.0, 6.0}, {}).saturated());
}

TEST(ExposureLook, OfDarknessIsNotLit) {
  Image<float> image(64, 64, 2.0F);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += float(i % 7) / 3.0F;
  image.at(20, 20) = 200.0F;  // hot
  EXPECT_FALSE(judge_exposure(image, {7, 4.0, 6.0}, {}).lit);
  EXPECT_FALSE(judge_exposure(Image<float>(64, 64, 0.0F), {1, 4.0, 6.0}, {}).lit);
}

TEST(ExposureLook, OfAnImageAtFullScaleIsSaturated) {
  const auto look = judge_exposure(Image<float>(64, 64, NAN), {19, 4.0, 6.0}, {});
  EXPECT_TRUE(look.saturated());
  EXPECT_TRUE(look.lit || look.saturated());
  EXPECT_EQ(look.saturated_pixels, 64 * 64);
  EXPECT_EQ(look.fraction(), 1.0);
}

TEST(ExposureLook, UsesTheFormatsFullScale) {
  CameraSettings settings;
  settings.pixel_format = PixelFormat::mono12;
  const auto look = judge_exposure(image_with(7, 2000.0F), {7, 4.0, 6.0}, settings);
  EXPECT_NEAR(look.fraction(), 2002.0 / 4095.0, 0.001);
}

constexpr double kPitchPx = 28.3;

/// Image of 9 x 9 spots kPitchPx apart, whose middles of `width` x `width` pixels are saturated.
/// Each row is `shift` pitches right of the one above, `row_px` apart; all are turned (rad).
Image<float> saturated_array(int width, double first_px = 30.0, double shift = 0.0,
                             double row_px = kPitchPx, double turned = 0.0) {
  Image<float> image(700, 700);
  const double c = std::cos(turned), s = std::sin(turned);
  for (int spot = 0; spot < 81; ++spot) {
    const double right = kPitchPx * (spot % 9 + std::fmod(shift * (spot / 9), 1.0));
    const double down = row_px * (spot / 9);
    const int x = int(200.0 + first_px + c * right - s * down);
    const int y = int(200.0 + first_px + s * right + c * down);
    for (int k = 0; k < width * width; ++k) {
      image.at(x + k % width, y + k / width) = std::numeric_limits<float>::infinity();
    }
  }
  return image;
}

TEST(SaturatedSpots, AreCountedOnceEach) {
  for (const int width : {2, 8, 12}) {
    for (const double first_px : {30.0, 37.0, 43.0, 50.5}) {
      EXPECT_EQ(count_saturated_spots(saturated_array(width, first_px), kPitchPx), 81);
    }
    const auto hexagonal = saturated_array(width, 30.0, 0.5, std::sqrt(0.75) * kPitchPx);
    EXPECT_EQ(count_saturated_spots(hexagonal, kPitchPx), 81);
    const auto turned = saturated_array(width, 30.0, 0.0, kPitchPx, 0.25 * std::numbers::pi);
    EXPECT_EQ(count_saturated_spots(turned, kPitchPx), 81);
  }
  EXPECT_EQ(count_saturated_spots(saturated_array(0), kPitchPx), 0);
}

TEST(SaturatedSpots, AreNotSinglePixels) {
  EXPECT_EQ(count_saturated_spots(saturated_array(1), kPitchPx), 0) << "as hot pixels are";
}

}  // namespace
}  // namespace ovws
