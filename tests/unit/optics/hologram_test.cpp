/// The hologram's grey levels against the formula they are meant to show.
#include "core/optics/hologram.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/unit/optics/rendered.hpp"

namespace ovws {
namespace {

using test::rendered;

/// The stated rule, written out: to the nearest 1/65536 wave (a tie to the even one), and of that
/// the top 8 bits.
std::int64_t phase16(double waves) {
  return std::llrint(waves * 65536.0);
}
std::uint8_t step_of(std::int64_t phase) {
  return static_cast<std::uint8_t>((((phase % 65536) + 65536) % 65536) / 256);
}

HologramRenderer renderer_of(const HologramConfig& config) {
  return HologramRenderer::make(config).value();
}

/// The modes at an SLM pixel; 0 outside the default pupil.
double shown_waves(std::span<const Mode> modes, int x, int y) {
  const Vec2 at{(x - 639.5) / 384.0, (y - 383.5) / 384.0};
  return norm(at) <= 1.0 ? wavefront(modes, at) : 0.0;
}

/// The sensor's phase in waves at an SLM pixel, straight from the paper's equation 4; 0 outside.
double sensor_waves(const HologramConfig& config, const Lattice& lattice, int x, int y) {
  const double px = x - 0.5 * (config.slm.width_px - 1);
  const double py = y - 0.5 * (config.slm.height_px - 1);
  for (const Subaperture& s : lattice.subapertures) {
    const double rx = px - s.centre_px.x;
    const double ry = py - s.centre_px.y;
    if (std::hypot(rx, ry) > lattice.diameter_px / 2.0) continue;
    const double fx = (200.0 + 0.25 * s.centre_px.x) / 1280.0;
    const double fy = (20.0 + 0.25 * s.centre_px.y) / 768.0;
    return config.sensor.charge * std::atan2(ry, rx) / (2.0 * std::numbers::pi) + fx * px + fy * py;
  }
  return 0.0;
}

std::shared_ptr<Image<float>> random_flatness(const SlmGeometry& slm) {
  auto map = std::make_shared<Image<float>>(slm.width_px, slm.height_px);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> waves(-0.7F, 0.7F);
  for (float& value : map->pixels) value = waves(random);
  return map;
}

TEST(Hologram, BaseGratingEqualsTheFormulaInThePupil) {
  const auto grey = rendered({}, HologramKind::grating);
  ASSERT_EQ(grey.width, 1280);
  ASSERT_EQ(grey.height, 768);
  int differ = 0;
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const bool in_pupil = norm(Vec2{x - 639.5, y - 383.5}) <= 384.0;
      const double waves =
          in_pupil ? 200.0 / 1280.0 * (x - 639.5) + 20.0 / 768.0 * (y - 383.5) : 0.0;
      differ += grey.at(x, y) != step_of(phase16(waves));
    }
  }
  EXPECT_EQ(differ, 0);
}

TEST(Hologram, SensorEqualsTheFormulaAtEveryPixelForAnyCharge) {
  for (const int charge : {-2, 0, 1, 3}) {
    HologramConfig config;
    config.sensor.charge = charge;
    const Lattice lattice = renderer_of(config).lattice();
    const auto grey = rendered(config, HologramKind::sensor);
    int differ = 0;
    for (int y = 0; y < 768; ++y) {
      for (int x = 0; x < 1280; ++x) {
        differ += grey.at(x, y) != step_of(phase16(sensor_waves(config, lattice, x, y)));
      }
    }
    EXPECT_EQ(differ, 0) << "charge " << charge;
  }
}

TEST(Hologram, ModesAndFlatnessAddUpBeforeTheLut) {
  HologramConfig config;
  config.flatness_waves = random_flatness(config.slm);
  for (int k = 0; k < 256; ++k) config.lut[k] = static_cast<std::uint8_t>(200 - k / 2);
  const std::vector<Mode> modes{{0, 0.1}, {3, 0.5}, {12, -0.3}, {40, 0.05}};
  const Lattice lattice = renderer_of(config).lattice();
  const auto grey = rendered(config, HologramKind::sensor, modes);
  std::mt19937 random(5);
  int differ = 0;
  for (int i = 0; i < 20000; ++i) {
    const int x = std::uniform_int_distribution(0, 1279)(random);
    const int y = std::uniform_int_distribution(0, 767)(random);
    const double pattern = sensor_waves(config, lattice, x, y) + config.flatness_waves->at(x, y);
    const double added = shown_waves(modes, x, y);
    differ += grey.at(x, y) != config.lut[step_of(phase16(pattern) + phase16(added))];
  }
  EXPECT_EQ(differ, 0);
}

TEST(Hologram, StaysWithinOneStepOfTheUnroundedFormula) {
  // Two roundings of at most half a 1/65536 each can cross a boundary between steps, so at most
  // one pixel in 256 may differ from the formula in full precision, and by one step only.
  const std::vector<Mode> modes{{3, 0.5}, {7, 0.21}};
  const HologramConfig config;
  const Lattice lattice = renderer_of(config).lattice();
  const auto grey = rendered(config, HologramKind::sensor, modes);
  int differ = 0;
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const double waves = sensor_waves(config, lattice, x, y) + shown_waves(modes, x, y);
      const int step = static_cast<int>(std::floor((waves - std::floor(waves)) * 256.0));
      const int apart = (grey.at(x, y) - step + 256) % 256;
      EXPECT_TRUE(apart <= 1 || apart == 255);
      differ += apart != 0;
    }
  }
  EXPECT_LT(differ, 1280 * 768 / 256);
}

TEST(Hologram, ChargeWindsFromXTowardsYWithYDown) {
  HologramConfig config;
  config.sensor.grooves = {0.0, 0.0};
  config.sensor.spacing = 0.0;
  const auto grey = rendered(config, HologramKind::sensor);
  // The central subaperture's centre is between pixels 639|640 and 383|384.
  EXPECT_NEAR(grey.at(680, 386), 2.5 / 40.5 / (2.0 * std::numbers::pi) * 256.0, 1.0);
  EXPECT_NEAR(grey.at(680, 424), 32.0, 1.0);
  EXPECT_NEAR(grey.at(599, 424), 96.0, 1.0);
  EXPECT_NEAR(grey.at(599, 343), 160.0, 1.0);
  EXPECT_NEAR(grey.at(680, 343), 224.0, 1.0);
}

TEST(Hologram, IsCentredBetweenTheMiddlePixels) {
  HologramConfig config;
  config.sensor.charge = 0;
  config.sensor.grooves = {0.0, 0.0};
  config.sensor.spacing = 0.0;
  const auto grey = rendered(config, HologramKind::sensor, {{4, 1.3}});
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 640; ++x) {
      ASSERT_EQ(grey.at(x, y), grey.at(1279 - x, y));
      ASSERT_EQ(grey.at(x, y), grey.at(x, 767 - y));
    }
  }
}

TEST(Hologram, FlatShowsOnlyTheFlatnessMap) {
  HologramConfig config;
  config.flatness_waves = random_flatness(config.slm);
  const auto grey = rendered(config, HologramKind::flat, {{3, 0.5}});
  for (int i = 0; i < grey.width * grey.height; ++i) {
    ASSERT_EQ(grey.pixels[i], step_of(phase16(config.flatness_waves->pixels[i])));
  }
  const auto dark = rendered({}, HologramKind::flat, {{3, 0.5}});
  EXPECT_EQ(dark.pixels, std::vector<std::uint8_t>(1280 * 768, 0));
}

TEST(Hologram, GratingCarriesTheCorrectionInThePupil) {
  const auto plain = rendered({}, HologramKind::grating);
  const auto corrected = rendered({}, HologramKind::grating, {{0, 0.25}});
  for (int y = 0; y < plain.height; ++y) {
    for (int x = 0; x < plain.width; ++x) {
      const bool in_pupil = norm(Vec2{x - 639.5, y - 383.5}) <= 384.0;
      const auto expected = static_cast<std::uint8_t>(plain.at(x, y) + (in_pupil ? 64 : 0));
      ASSERT_EQ(corrected.at(x, y), expected) << x << ' ' << y;
    }
  }
}

TEST(Hologram, IdentifyImageShowsEachOrientationOfTheScreen) {
  const auto picture = rendered({}, HologramKind::identify);
  const auto differing = [&](auto at) {
    int count = 0;
    for (int y = 0; y < 768; ++y) {
      for (int x = 0; x < 1280; ++x) count += picture.at(x, y) != at(x, y);
    }
    return count;
  };
  EXPECT_EQ(picture.at(0, 0), 255);
  EXPECT_EQ(picture.at(1279, 767), 255);
  EXPECT_GT(differing([&](int x, int y) { return picture.at(1279 - x, y); }), 100000);
  EXPECT_GT(differing([&](int x, int y) { return picture.at(x, 767 - y); }), 100000);
  EXPECT_GT(differing([&](int x, int y) { return picture.at(1279 - x, 767 - y); }), 100000);
}

TEST(Hologram, RendersExtremeAndNonFiniteModes) {
  // check_sampling refuses such modes, but rendering them must not be undefined behaviour.
  for (const double waves : {1e300, -1e300, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(rendered({}, HologramKind::sensor, {{kMaxZernikeIndex, waves}}).height, 768);
  }
}

TEST(Hologram, RefusesAFlatnessMapThatDoesNotFit) {
  HologramConfig config;
  config.flatness_waves = std::make_shared<Image<float>>(768, 1280);
  EXPECT_EQ(HologramRenderer::make(config).error().field, "slm.flatness");
  auto holed = std::make_shared<Image<float>>(1280, 768);
  holed->at(3, 4) = std::numeric_limits<float>::quiet_NaN();
  config.flatness_waves = holed;
  EXPECT_EQ(HologramRenderer::make(config).error().field, "slm.flatness");
}

TEST(Hologram, RefusesASensorWithoutALattice) {
  HologramConfig config;
  config.sensor.subapertures_across = 1;
  EXPECT_EQ(HologramRenderer::make(config).error().field, "sensor.subapertures_across");
}

class Sampling : public ::testing::Test {
 protected:
  bool allowed(int j, double waves) const {
    const std::vector<Mode> modes{{j, waves}};
    const auto result = renderer_.check_sampling(modes);
    if (!result) {
      EXPECT_EQ(result.error().code, Errc::invalid);
      EXPECT_EQ(result.error().field, "modes");
    }
    return result.has_value();
  }
  HologramRenderer renderer_ = renderer_of({});
};

TEST_F(Sampling, CountsTheCarrierOfTheSteepestSubaperture) {
  // Tilt j = 2 has dW/dx = 2 c / 384. The gratings span (200 -+ 0.25 * 307.2) / 1280 in x.
  const double room_up = 0.5 - (200.0 + 76.8) / 1280.0;
  const double room_down = 0.5 + (200.0 - 76.8) / 1280.0;
  EXPECT_TRUE(allowed(2, 192.0 * room_up * 0.999));
  EXPECT_FALSE(allowed(2, 192.0 * room_up * 1.001));
  EXPECT_TRUE(allowed(2, -192.0 * room_down * 0.999));
  EXPECT_FALSE(allowed(2, -192.0 * room_down * 1.001));
  // And 20 +- 0.25 * 2 * 153.6 * sqrt(3)/2 over 768 in y.
  const double room_y = 0.5 - (20.0 + 0.25 * 307.2 * std::sqrt(0.75)) / 768.0;
  EXPECT_TRUE(allowed(1, 192.0 * room_y * 0.999));
  EXPECT_FALSE(allowed(1, 192.0 * room_y * 1.001));
}

TEST_F(Sampling, AllowsWhatAnExperimentUsesAndAnyPiston) {
  EXPECT_TRUE(allowed(3, 2.0));
  EXPECT_TRUE(allowed(12, -1.0));
  EXPECT_TRUE(allowed(0, 1000.0));
  EXPECT_TRUE(renderer_.check_sampling({}).has_value());
}

TEST_F(Sampling, LooksAtTheSteepestPixelNotOnlyAtCentres) {
  // Defocus: dW/dx = 4 sqrt(3) c x / 384^2, steepest at the right edge of the right subaperture,
  // x = 384 to within a pixel.
  const double room = 0.5 - (200.0 + 76.8) / 1280.0;
  const double most = room * 384.0 / (4.0 * std::sqrt(3.0));
  EXPECT_TRUE(allowed(4, most * 0.999));
  EXPECT_FALSE(allowed(4, most * 1.003));
}

TEST_F(Sampling, RefusesUnknownModesAndNumbersThatAreNone) {
  EXPECT_FALSE(allowed(-1, 0.1));
  EXPECT_FALSE(allowed(kMaxZernikeIndex + 1, 0.1));
  EXPECT_FALSE(allowed(3, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(allowed(3, std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(allowed(0, 1e300));
}

}  // namespace
}  // namespace ovws
