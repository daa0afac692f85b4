/// Turbulence of the twin: reproducible, with the configured strength and spectrum, carried by the
/// wind, and the same in the light as in the ground truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "core/optics/zernike.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/slm_model.hpp"
#include "drivers/twin/turbulence.hpp"
#include "tests/contract/twin/model_case.hpp"

namespace ovws::twin {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

/// Points of a square grid that lie in the pupil, in pupil radii.
std::vector<Vec2> pupil_points(int across) {
  std::vector<Vec2> points;
  for (int y = 0; y < across; ++y) {
    for (int x = 0; x < across; ++x) {
      const Vec2 at{(2.0 * x + 1.0) / across - 1.0, (2.0 * y + 1.0) / across - 1.0};
      if (norm(at) <= 1.0) points.push_back(at);
    }
  }
  return points;
}

TEST(Turbulence, TheSameSeedIsTheSameAirAndAnotherIsNot) {
  TurbulenceConfig config;
  const Turbulence a(config), b(config);
  config.seed = 2;
  const Turbulence other(config);
  EXPECT_EQ(a.modes(kNow), b.modes(kNow));
  EXPECT_EQ(a.waves({0.3, -0.2}, kNow), b.waves({0.3, -0.2}, kNow));
  EXPECT_NE(a.modes(kNow), other.modes(kNow));
}

TEST(Turbulence, IsCarriedByTheWindAsItIs) {
  const Turbulence air({.speed_pupils_per_s = 0.8, .direction_deg = 30.0});
  constexpr double kSeconds = 0.7;
  const Vec2 radii = 2.0 * 0.8 * kSeconds * Vec2{std::cos(std::numbers::pi / 6), 0.5};
  for (const Vec2 at : pupil_points(7)) {
    EXPECT_NEAR(air.waves(at, kNow + std::int64_t(kSeconds * kSecond)), air.waves(at - radii, kNow),
                1e-6);
  }
}

TEST(Turbulence, EachLayerIsCarriedByItsWind) {
  const std::vector<AirLayer> still{{2.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  std::vector<AirLayer> one_moves = still;
  one_moves[1].speed_pupils_per_s = 3.0;
  const Turbulence unmoved({.layers = still}), moved({.layers = one_moves});
  // In a long time the moving layer forgets itself: twice its part of the variance.
  double change = 0.0, power = 0.0;
  for (int n = 0; n < 300; ++n) {
    const std::int64_t t_ns = kNow + n * 7 * kSecond;
    EXPECT_EQ(unmoved.waves({0.3, 0.1}, t_ns), unmoved.waves({0.3, 0.1}, kNow));
    const auto now = moved.modes(t_ns), later = moved.modes(t_ns + 5 * kSecond);
    for (std::size_t j = 3; j < now.size(); ++j) change += std::pow(later[j] - now[j], 2);
    const auto other = Turbulence({.seed = n + 2}).modes(kNow);
    for (std::size_t j = 3; j < now.size(); ++j) power += other[j] * other[j];
  }
  EXPECT_NEAR(change / power, 2.0 / 3.0, 0.2);
}

TEST(Turbulence, VibrationsAreSinesOfTheirModes) {
  const Turbulence air(
      {.rms_waves = 0.0, .tilt = false, .vibrations = {{1, 0.03, 5.0}, {4, 0.05, 17.0}}});
  double tilt = 0.0, defocus = 0.0;
  constexpr int kMoments = 1000;  // over one second: whole numbers of periods
  for (int n = 0; n < kMoments; ++n) {
    const std::int64_t t_ns = kNow + n * kSecond / kMoments;
    const auto modes = air.modes(t_ns);
    tilt += modes[1] * modes[1] / kMoments;
    defocus += modes[4] * modes[4] / kMoments;
    EXPECT_NEAR(modes[1], air.modes(t_ns + kSecond / 5)[1], 1e-6);
    const Vec2 at{0.2, -0.6};
    EXPECT_NEAR(air.waves(at, t_ns), modes[1] * zernike(1, at) + modes[4] * zernike(4, at), 1e-12);
  }
  EXPECT_NEAR(std::sqrt(tilt), 0.03, 1e-6);
  EXPECT_NEAR(std::sqrt(defocus), 0.05, 1e-6);
}

TEST(Turbulence, ASampleIsTheWavefrontOnItsGrid) {
  for (const bool tilt : {true, false}) {
    const Turbulence air({.tilt = tilt, .vibrations = {{7, 0.1, 3.0}}});
    const Vec2 first{-1.1, -1.2};
    const Eigen::MatrixXf sample = air.sample(first, 0.15, 16, kNow);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) {
        const Vec2 at = first + 0.15 * Vec2{double(x), double(y)};
        EXPECT_NEAR(sample(x, y), air.waves(at, kNow), 1e-5);
      }
    }
  }
}

TEST(Turbulence, ModesAreItsProjectionOverThePupil) {
  for (const bool tilt : {true, false}) {
    const Turbulence air({.rms_waves = 0.3, .outer_scale_pupils = 3.0, .tilt = tilt});
    const auto points = pupil_points(300);
    Turbulence::Modes sums{};
    for (const Vec2 at : points) {
      const double waves = air.waves(at, kNow);
      for (int j = 0; j < Turbulence::kModes; ++j) {
        sums[std::size_t(j)] += waves * zernike(j, at) / double(points.size());
      }
    }
    const auto modes = air.modes(kNow);
    for (std::size_t j = 0; j < modes.size(); ++j) {
      EXPECT_NEAR(modes[j], sums[j], 2e-3) << "j = " << j << ", tilt " << tilt;
    }
    EXPECT_EQ(modes[1] == 0.0, !tilt);
  }
}

/// Mean squares of the modes over moments far apart.
Turbulence::Modes mean_squares(const Turbulence& air, int moments) {
  Turbulence::Modes sums{};
  std::mt19937_64 random(3);
  for (int n = 0; n < moments; ++n) {
    const auto modes = air.modes(std::int64_t(random() >> 2));
    for (std::size_t j = 0; j < sums.size(); ++j) sums[j] += modes[j] * modes[j] / moments;
  }
  return sums;
}

TEST(Turbulence, HasTheStrengthThatIsConfigured) {
  const Turbulence air({.rms_waves = 0.2, .tilt = false});
  const auto points = pupil_points(20);
  std::mt19937_64 random(7);
  double power = 0.0;
  constexpr int kMoments = 300;
  for (int n = 0; n < kMoments; ++n) {
    const auto t_ns = std::int64_t(random() >> 2);
    for (const Vec2 at : points) power += std::pow(air.waves(at, t_ns), 2);
  }
  EXPECT_NEAR(std::sqrt(power / kMoments / double(points.size())), 0.2, 0.2 * 0.06);
}

TEST(Turbulence, SharesItsPowerAmongModesAsKolmogorovsDoes) {
  // Noll 1976, Table IV, residuals: tilt 0.448 each, astigmatism and defocus 0.0232 each, coma
  // 0.0062 each, of (D / r0)^(5/3) rad^2. An outer scale of 1000 pupils reduces the tilt by about
  // a seventh and leaves the others unchanged.
  double astigmatism = 0.0, coma = 0.0, tilt = 0.0;
  for (int seed = 1; seed <= 4; ++seed) {
    const auto power = mean_squares(Turbulence({.outer_scale_pupils = 1000.0, .seed = seed}), 3000);
    astigmatism += (power[3] + power[4] + power[5]) / 3;
    coma += (power[7] + power[8]) / 2;
    tilt += (power[1] + power[2]) / 2;
  }
  EXPECT_NEAR(coma / astigmatism, 0.0062 / 0.0232, 0.15 * 0.0062 / 0.0232);
  EXPECT_NEAR(tilt / astigmatism, 0.448 / 0.0232, 0.25 * 0.448 / 0.0232);
}

TEST(SlmModel, LightCarriesTheTurbulenceOfTheMoment) {
  const Config config = parse_config("{}").value();
  SlmModel slm(config);
  for (const bool tilt : {true, false}) {
    const Turbulence air({.rms_waves = 0.3, .tilt = tilt});
    slm.set_turbulence(&air, kNow);
    Image<std::complex<float>> field(1280, 768);
    slm.modulate(Image<std::uint8_t>(1280, 768), 368, 768, field);
    double worst = 0.0;
    for (int y = 368; y < 768; y += 7) {
      for (int x = 0; x < 1280; x += 5) {
        const Vec2 at{(x - 639.5) / 384.0, (y - 383.5) / 384.0};
        const double truth = norm(at) > 1.0 ? 0.0 : air.waves(at, kNow);
        const double got = std::arg(std::complex<double>(field.at(x, y))) / (2 * std::numbers::pi);
        worst = std::max(worst, std::abs(std::remainder(got - truth, 1.0)));
      }
    }
    EXPECT_LT(worst, 1e-3) << "tilt " << tilt;
  }
  slm.set_turbulence(nullptr, kNow);
  Image<std::complex<float>> still(1280, 768);
  slm.modulate(Image<std::uint8_t>(1280, 768), 0, 768, still);
  EXPECT_EQ(still.at(640, 384), std::complex<float>(1.0F));
}

TEST(Bench, EachFramesLightIsOfTheMomentWhenItWasBegun) {
  Bench bench(parse_config(R"({"turbulence": {"rms_waves": 0.2}})").value());
  const std::jthread worker([&bench](const std::stop_token& token) { bench.work(token); });
  const std::stop_source stop;
  const auto frame = [&](std::int64_t t_ns) {
    const std::uint64_t begun = bench.begin({192, 192, 64, 64}, t_ns);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    std::shared_ptr<const Scene> ready, light;
    while ((light = bench.scene(begun, ready, deadline, stop.get_token())) != ready) ready = light;
    bench.note_sent(std::uint64_t(t_ns - kNow), t_ns, *light);
    return light;
  };
  const Turbulence air(*bench.truth().turbulence);
  const auto first = frame(kNow), second = frame(kNow + kSecond / 10);
  EXPECT_EQ(first->turbulence, air.modes(kNow));
  EXPECT_EQ(second->turbulence, air.modes(kNow + kSecond / 10));
  EXPECT_NE(first->patterns[0].intensity->pixels, second->patterns[0].intensity->pixels);
  EXPECT_EQ(frame(kNow)->patterns[0].intensity->pixels, first->patterns[0].intensity->pixels);
  ASSERT_EQ(bench.frame_truths().size(), 3U);
  EXPECT_EQ(bench.frame_truths()[1].frame_id, std::uint64_t(kSecond / 10));
  EXPECT_EQ(bench.frame_truths()[1].turbulence, second->turbulence);
  for (int n = 0; n < 40; ++n) bench.note_sent(7, kNow, *second);
  EXPECT_EQ(bench.frame_truths().size(), 32U);
}

TEST(Bench, TheNextMomentIsComputedAheadAndIsTheOneThatTheSceneStates) {
  constexpr Roi kWindow{192, 192, 64, 64};
  // So long that no frame of this test takes longer.
  constexpr std::int64_t kPeriod = 20 * kSecond, kEarly = Bench::kEarlyMomentNs / 2;
  const Config config = parse_config(R"({"turbulence": {"rms_waves": 0.2}})").value();
  const Turbulence air(*config.truth.turbulence);
  Bench bench(config);
  const std::jthread worker([&bench](const std::stop_token& token) { bench.work(token); });
  const auto far_fields = [&bench] { return bench.status().far_fields; };
  const auto wait_for = [&](std::uint64_t count) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (far_fields() < count && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(far_fields(), count);
  };
  const auto check = [&](std::int64_t t_ns, std::int64_t moment_ns,
                         const Image<std::uint8_t>& grey) {
    const std::uint64_t begun = bench.begin(kWindow, t_ns, kPeriod);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    const std::stop_source stop;
    const auto scene = bench.scene(begun, nullptr, deadline, stop.get_token());
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->t_ns, moment_ns);
    EXPECT_EQ(scene->turbulence, air.modes(scene->t_ns));
    bench.note_sent(1, t_ns, *scene);
    BenchModel model(config);
    model.set_light(config.truth);
    model.set_window(kWindow, config.truth.geometry);
    model.set_turbulence(&air, scene->t_ns);
    EXPECT_EQ(scene->patterns[0].intensity->pixels, model.intensity(grey).pixels);
  };
  const Image<std::uint8_t> flat = bench.shown()->front();
  Image<std::uint8_t> half = flat;
  std::fill_n(half.pixels.begin(), half.pixels.size() / 2, std::uint8_t{60});
  check(kNow, kNow, flat);
  wait_for(2);  // with the next moment
  check(kNow + kPeriod, kNow + kPeriod - kEarly, flat);
  wait_for(3);  // of the moment after, and none again of this one
  check(kNow + 2 * kPeriod + kEarly, kNow + 2 * kPeriod - kEarly, flat);
  wait_for(4);
  bench.show({half}, std::chrono::steady_clock::now() - std::chrono::seconds(1));
  check(kNow + 3 * kPeriod + kEarly, kNow + 3 * kPeriod, half);
  check(kNow + 5 * kPeriod, kNow + 5 * kPeriod, half);  // not the moment computed ahead
}

TEST(TwinConfig, TurbulenceIsReadStrictly) {
  EXPECT_FALSE(parse_config("{}")->truth.turbulence);
  EXPECT_FALSE(parse_config(R"({"turbulence": null})")->truth.turbulence);
  const auto config = parse_config(R"({"turbulence": {"rms_waves": 0.3, "seed": 9}})");
  EXPECT_EQ(config->truth.turbulence, (TurbulenceConfig{.rms_waves = 0.3, .seed = 9}));
  EXPECT_EQ(parse_config(R"({"turbulence": {"rms": 1}})").error().field, "turbulence.rms");
  EXPECT_EQ(parse_config(R"({"turbulence": 3})").error().field, "turbulence");
}

}  // namespace
}  // namespace ovws::twin
