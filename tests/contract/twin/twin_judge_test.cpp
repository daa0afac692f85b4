/// The twin's judge on a known wavefront, a known SLM and a known correction.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "core/optics/hologram.hpp"
#include "drivers/twin/judge.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

using Modes = std::vector<Mode>;

/// The daemon's hologram of the pattern with these modes added.
Image<std::uint8_t> shown(const Config& config, Pattern pattern, const Modes& modes = {}) {
  HologramConfig hologram;
  hologram.sensor = config.sensor;
  Image<std::uint8_t> grey;
  HologramRenderer::make(hologram)->render(
      pattern == Pattern::sensor ? HologramKind::sensor : HologramKind::grating, modes, grey);
  return grey;
}

Modes opposite(Modes modes) {
  for (Mode& mode : modes) mode.waves = -mode.waves;
  return modes;
}

class BothPatterns : public ::testing::TestWithParam<Pattern> {};
INSTANTIATE_TEST_SUITE_P(Judge, BothPatterns, ::testing::Values(Pattern::sensor, Pattern::grating),
                         [](const auto& p) {
                           return std::string(p.param == Pattern::sensor ? "Sensor" : "Grating");
                         });

TEST_P(BothPatterns, APerfectBenchIsPerfect) {
  const Config config = config_of();
  const auto verdict = Judge(config).judge(GetParam(), shown(config, GetParam()), {}, nullptr, 0);
  ASSERT_TRUE(verdict);
  EXPECT_LT(verdict->rms_with_tilt_waves, 0.001);
  EXPECT_GT(verdict->strehl_with_tilt, 0.9999);
  EXPECT_GT(verdict->first_order, 0.9999);
}

TEST_P(BothPatterns, AnAberrationAndItsExactOppositeLeaveNothing) {
  const Config config = config_of();
  const Modes hidden{{3, 0.2}, {7, -0.15}, {12, 0.1}, {1, 0.12}};  // 0.3 wave RMS
  const auto verdict = Judge(config).judge(GetParam(), shown(config, GetParam(), opposite(hidden)),
                                           {hidden, {}}, nullptr, 0);
  ASSERT_TRUE(verdict);
  EXPECT_LT(verdict->rms_with_tilt_waves, 0.003);
  EXPECT_GT(verdict->strehl_with_tilt, 0.999);
}

TEST_P(BothPatterns, FindsAWavefrontOfManyWaves) {
  const Config config = config_of();
  const Modes hidden{{1, 1.5}, {2, -2.0}, {4, 1.2}, {5, -0.8}, {8, 0.5}, {17, 0.2}};
  const auto start = std::chrono::steady_clock::now();
  const auto verdict =
      Judge(config).judge(GetParam(), shown(config, GetParam()), {hidden, {}}, nullptr, 0);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  std::printf("  %.0f ms\n", took.count());
  ASSERT_TRUE(verdict);
  Modes found = verdict->modes;
  for (const Mode& mode : hidden) found[std::size_t(mode.j)].waves -= mode.waves;
  for (std::size_t j = 1; j < found.size(); ++j) {
    EXPECT_NEAR(found[j].waves, 0.0, 0.002) << "j = " << j;
  }
}

TEST_P(BothPatterns, SaysSoWhereThereIsNoWavefront) {
  const Config config = config_of();
  Image<std::uint8_t> grey(1280, 768);
  std::mt19937 random(2);
  for (std::uint8_t& pixel : grey.pixels) pixel = std::uint8_t(random());
  EXPECT_FALSE(Judge(config).judge(GetParam(), grey, {}, nullptr, 0));
}

TEST(Judge, SaysSoWhereTheOtherPatternIsShown) {
  const Config config = config_of();
  Judge judge(config);
  EXPECT_FALSE(judge.judge(Pattern::sensor, shown(config, Pattern::grating), {}, nullptr, 0));
  EXPECT_FALSE(judge.judge(Pattern::grating, shown(config, Pattern::sensor), {}, nullptr, 0));
}

TEST_P(BothPatterns, APoorSlmIsNotTakenForAWavefront) {
  const Config config = config_of(R"({"slm": {"gamma": 1.3, "depth_waves": 0.9}})");
  const auto verdict = Judge(config).judge(GetParam(), shown(config, GetParam()), {}, nullptr, 0);
  ASSERT_TRUE(verdict);
  EXPECT_LT(verdict->first_order, 0.97);
  EXPECT_LT(verdict->rms_waves, 0.002);
  EXPECT_GT(verdict->strehl, 0.9998);
  for (std::size_t j = 1; j < verdict->modes.size(); ++j) {
    EXPECT_NEAR(verdict->modes[j].waves, 0.0, 0.002) << "j = " << j;
  }
}

TEST_P(BothPatterns, TurbulenceIsPartOfTheWavefront) {
  const Config config = config_of();
  const Turbulence air({.rms_waves = 0.08, .outer_scale_pupils = 5.0});
  const auto verdict = Judge(config).judge(GetParam(), shown(config, GetParam()), {}, &air, kNow);
  ASSERT_TRUE(verdict);
  const auto truth = air.modes(kNow);
  for (const int j : {1, 2, 3, 4, 5}) {
    // The subapertures do not fill the pupil, so higher modes leak into the fit.
    EXPECT_NEAR(verdict->modes[std::size_t(j)].waves, truth[std::size_t(j)], 0.015) << j;
  }
}

TEST(Judge, StrehlOfAstigmatismIsThatOfMarechal) {
  const Config config = config_of();
  const auto verdict = Judge(config).judge(Pattern::grating, shown(config, Pattern::grating),
                                           {{{3, 0.1}}, {}}, nullptr, 0);
  ASSERT_TRUE(verdict);
  const double marechal = std::exp(-std::pow(2.0 * std::numbers::pi * 0.1, 2));
  EXPECT_NEAR(verdict->strehl, marechal, 0.02 * marechal);
  EXPECT_NEAR(verdict->strehl_with_tilt, marechal, 0.02 * marechal);
  EXPECT_NEAR(verdict->rms_waves, 0.1, 0.001);
  EXPECT_GT(verdict->first_order, 0.9999);
}

TEST(Judge, DistinguishesTiltFromTheRest) {
  const Config config = config_of();
  const auto verdict = Judge(config).judge(Pattern::grating, shown(config, Pattern::grating),
                                           {{{2, 0.25}}, {}}, nullptr, 0);
  ASSERT_TRUE(verdict);
  EXPECT_LT(verdict->rms_waves, 0.001);
  EXPECT_NEAR(verdict->rms_with_tilt_waves, 0.25, 0.001);
  EXPECT_GT(verdict->strehl, 0.9999);
  // Airy: (2 J1(x) / x)^2 with x = 2 pi 2 0.25 at the rim.
  const double airy = 2.0 * std::cyl_bessel_j(1.0, std::numbers::pi) / std::numbers::pi;
  EXPECT_NEAR(verdict->strehl_with_tilt, airy * airy, 0.002);
}

TEST_P(BothPatterns, FirstOrderIsTheEfficiencyOfTheSlm) {
  const Config config = config_of(R"({"slm": {"depth_waves": 0.7}})");
  const Modes hidden{{4, 0.3}};
  const auto verdict =
      Judge(config).judge(GetParam(), shown(config, GetParam()), {hidden, {}}, nullptr, 0);
  ASSERT_TRUE(verdict);
  // A blazed grating of 0.7 waves has the efficiency sinc^2(0.3).
  const double x = 0.3 * std::numbers::pi;
  EXPECT_NEAR(verdict->first_order, std::pow(std::sin(x) / x, 2), 0.01);
  EXPECT_NEAR(verdict->modes[4].waves, 0.3, 0.005);
}

TEST(Judge, FlatnessErrorIsInTheWavefrontAsTheTruthSays) {
  const Config config = config_of(R"({"slm": {"flatness_rms_waves": 0.4, "flatness_seed": 3}})");
  Judge judge(config);
  const auto flatness = judge.flatness_modes();
  ASSERT_TRUE(flatness);
  const auto verdict =
      judge.judge(Pattern::grating, shown(config, Pattern::grating), {}, nullptr, 0);
  ASSERT_TRUE(verdict);
  double power = 0.0;
  for (int j = 1; j < 21; ++j) {
    EXPECT_NEAR(verdict->modes[std::size_t(j)].waves, (*flatness)[std::size_t(j)].waves, 0.001);
    power += std::pow((*flatness)[std::size_t(j)].waves, 2);
  }
  EXPECT_GT(std::sqrt(power), 0.2);
  const auto none = Judge(config_of()).flatness_modes();
  ASSERT_TRUE(none);
  for (const Mode& mode : *none) EXPECT_NEAR(mode.waves, 0.0, 1e-4);
}

TEST(Judge, JudgesASmallPupilAndABeamThatIsNotUniform) {
  const Config config = config_of(R"({"sensor": {"pupil_diameter_px": 301},
                                  "light": {"shape": "gaussian", "diameter_px": 400}})");
  const Turbulence air({.rms_waves = 0.05, .tilt = false});
  for (const Pattern pattern : {Pattern::sensor, Pattern::grating}) {
    const auto verdict =
        Judge(config).judge(pattern, shown(config, pattern), {{{5, 0.2}}, {}}, &air, 123);
    ASSERT_TRUE(verdict);
    EXPECT_NEAR(verdict->modes[5].waves, 0.2 + air.modes(123)[5], 0.02);
    EXPECT_LT(verdict->strehl, 0.5);
  }
}

TEST(Judge, LutIsThatOfTheSlm) {
  const auto lut =
      Judge::lut_waves(config_of(R"({"slm": {"gamma": 2.0, "depth_waves": 1.2}})").slm);
  EXPECT_EQ(lut[0], 0.0);
  EXPECT_NEAR(lut[128], 0.3, 1e-12);
}

}  // namespace
}  // namespace ovws::twin
