/// The twin's DMD in pattern mode: bits of the colours, schedule, configuration, scenes and frames.
#include <gtest/gtest.h>
#include <zlib.h>

#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <thread>

#include "core/port/clock.hpp"
#include "drivers/twin/bench.hpp"
#include "drivers/twin/dmd.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/pixel_packing.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::int64_t kNowNs = 1'795'852'800'123'456'789;

/// Numbers of the patterns that a display of one colour turns on.
std::vector<int> patterns_of(std::uint32_t colour, const PatternMode& dmd) {
  constexpr int kWidth = 37;  // not a whole number of SIMD vectors
  const std::vector<std::uint32_t> pixels(kWidth, colour);
  Patterns patterns = dark_patterns(dmd, kWidth, 2);
  read_row(dmd, pixels.data(), 1, patterns);
  std::vector<int> on;
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    const std::set<std::uint8_t> levels(patterns[k].row(1), patterns[k].row(1) + kWidth);
    EXPECT_EQ(levels.size(), 1U);
    EXPECT_EQ(patterns[k].at(0, 0), 0) << "only row 1 was read";
    if (*levels.begin() != 0) on.push_back(int(k));
    EXPECT_TRUE(*levels.begin() == 0 || *levels.begin() == 255);
  }
  return on;
}

TEST(Dmd, PatternsAreTheBitsInTheConfiguredOrder) {
  using Numbers = std::vector<int>;
  constexpr std::uint32_t kColour = 0xff'01'80'42;  // red bit 0, green bit 7, blue bits 1 and 6
  EXPECT_EQ(patterns_of(kColour, {24, BitOrder::grb}), (Numbers{7, 8, 17, 22}));
  EXPECT_EQ(patterns_of(kColour, {24, BitOrder::rgb}), (Numbers{0, 15, 17, 22}));
  EXPECT_EQ(patterns_of(kColour, {24, BitOrder::bgr}), (Numbers{1, 6, 15, 16}));
  EXPECT_EQ(patterns_of(kColour, {8, BitOrder::grb}), (Numbers{7}));
}

TEST(Dmd, EachPixelHasItsOwnBits) {
  const PatternMode dmd{.patterns = 24};
  std::vector<std::uint32_t> pixels(100);
  for (std::uint32_t x = 0; x < 100; ++x) pixels[x] = 2'654'435'761U * (x + 1);
  Patterns patterns = dark_patterns(dmd, 100, 1);
  read_row(dmd, pixels.data(), 0, patterns);
  for (int x = 0; x < 100; ++x) {
    for (int k = 0; k < 8; ++k) {
      const auto bit = [&](int n) { return (pixels[std::size_t(x)] >> n & 1U) != 0 ? 255 : 0; };
      EXPECT_EQ(patterns[std::size_t(k)].at(x, 0), bit(8 + k));
      EXPECT_EQ(patterns[std::size_t(8 + k)].at(x, 0), bit(16 + k));
      EXPECT_EQ(patterns[std::size_t(16 + k)].at(x, 0), bit(k));
    }
  }
}

TEST(Dmd, VideoModeShowsTheBlueChannel) {
  const std::vector<std::uint32_t> pixels(20, 0xff'12'34'56);
  Patterns patterns = dark_patterns({}, 20, 1);
  ASSERT_EQ(patterns.size(), 1U);
  read_row({}, pixels.data(), 0, patterns);
  EXPECT_EQ(patterns[0].at(19, 0), 0x56);
}

TEST(PatternClock, ATimeTellsThePattern) {
  for (const int count : {2, 8, 24}) {
    const PatternMode dmd{.patterns = count};
    const PatternClock clock(dmd);
    const double period_ns = 1e9 / 60.0 / count;
    EXPECT_NEAR(clock.period_ns(), period_ns, 1e-6);
    std::int64_t pulse = clock.last_pulse(kNowNs);
    for (int n = 0; n < 10'000; ++n, ++pulse) {
      const std::int64_t t_ns = clock.time_of(pulse);
      EXPECT_EQ(clock.last_pulse(t_ns), pulse);
      EXPECT_EQ(clock.last_pulse(t_ns + std::int64_t(0.99 * period_ns)), pulse);
      // What a client does that knows the cycle only.
      EXPECT_EQ(std::llround(double(t_ns) / period_ns) % count, clock.pattern_of(pulse));
    }
    const std::int64_t cycle_ns = clock.next_cycle(kNowNs);
    EXPECT_EQ(clock.pattern_of(clock.last_pulse(cycle_ns)), 0);
    EXPECT_GT(cycle_ns, kNowNs);
    EXPECT_LE(cycle_ns, kNowNs + 16'666'667);
  }
}

TEST(PatternClock, PeriodsThatAreMissedAreCounted) {
  const PatternClock clock({.patterns = 5, .cycle_ms = 20.0});
  const std::int64_t first = clock.last_pulse(kNowNs);
  const std::int64_t t_ns = clock.time_of(first);
  for (const int missed : {0, 1, 4, 5, 23}) {
    const std::int64_t pulse = clock.last_pulse(t_ns + (1 + missed) * 4'000'000);
    EXPECT_EQ(pulse, first + 1 + missed);
    EXPECT_EQ(clock.pattern_of(pulse), (clock.pattern_of(first) + 1 + missed) % 5);
  }
}

TEST(PatternClock, AFrameShowsThePatternsOfItsExposure) {
  const PatternClock clock({.patterns = 5, .cycle_ms = 20.0});
  const std::int64_t t_ns = clock.next_cycle(kNowNs) + 4'000'000;  // pattern 1
  EXPECT_EQ(clock.exposed(t_ns, 100.0), (Exposed{1, 1}));
  EXPECT_EQ(clock.exposed(t_ns, 4000.0), (Exposed{1, 1}));
  EXPECT_EQ(clock.exposed(t_ns, 4100.0), (Exposed{1, 2}));
  EXPECT_EQ(clock.exposed(t_ns + 2'000'000, 4000.0), (Exposed{1, 2}));
  EXPECT_EQ(clock.exposed(t_ns + 12'000'000, 7000.0), (Exposed{4, 2}));
  EXPECT_EQ(clock.exposed(t_ns, 20'000.0), (Exposed{0, 5}));
  EXPECT_EQ(clock.exposed(t_ns, 500'000.0), (Exposed{0, 5}));
  // The next trigger after an exposure.
  EXPECT_EQ(clock.last_pulse_in(t_ns, 4000.0), clock.last_pulse(t_ns));
  EXPECT_EQ(clock.last_pulse_in(t_ns, 4100.0), clock.last_pulse(t_ns) + 1);
}

TEST(TwinConfig, PatternModeIsReadStrictly) {
  const auto config = parse_config(
      R"({"modulator": "dmd", "dmd": {"slots": 8, "bit_order": "BGR", "cycle_ms": 20}})");
  ASSERT_TRUE(config) << config.error().reason;
  EXPECT_EQ(config->dmd.patterns, 8);
  EXPECT_EQ(config->dmd.bit_order, BitOrder::bgr);
  EXPECT_EQ(config->dmd.cycle_ms, 20.0);
  const auto refused = [](const std::string& dmd) {
    return parse_config(R"({"modulator": "dmd", "dmd": )" + dmd + "}").error().field;
  };
  EXPECT_EQ(refused(R"({"slots": 1})"), "dmd.slots");
  EXPECT_EQ(refused(R"({"slots": 25})"), "dmd.slots");
  EXPECT_EQ(refused(R"({"slots": 2.5})"), "dmd.slots");
  EXPECT_EQ(refused(R"({"bit_order": "GBR"})"), "dmd.bit_order");
  EXPECT_EQ(refused(R"({"cycle_ms": 1})"), "dmd.cycle_ms");
  EXPECT_EQ(refused(R"({"pattern": 8})"), "dmd.pattern");
  EXPECT_EQ(parse_config(R"({"dmd": {"slots": 8}})").error().field, "dmd.slots");
  EXPECT_EQ(parse_config(R"({"modulator": "fixed", "dmd": {"slots": 8}})").error().field,
            "dmd.slots");
  EXPECT_EQ(parse_config("{}")->dmd.patterns, 0);
}

/// A small DMD with four patterns of 4 ms.
class PatternBench : public ::testing::Test {
 protected:
  static constexpr Roi kWindow{224, 224, 64, 64};
  static constexpr std::int64_t kPeriodNs = 4'000'000, kSecondNs = 1'000'000'000;
  static constexpr int kWidth = 640, kHeight = 384;

  /// Pattern k is on in columns that are a multiple of k + `coarsest`.
  static Patterns stripes(int coarsest) {
    Patterns patterns = dark_patterns({.patterns = 4}, kWidth, kHeight);
    for (std::size_t k = 0; k < patterns.size(); ++k) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; x += coarsest + int(k)) patterns[k].at(x, y) = 255;
      }
    }
    return patterns;
  }
  std::shared_ptr<const Scene> frame(std::int64_t t_ns) {
    const Exposed exposed = bench.clock()->exposed(t_ns, 100.0);
    const std::uint64_t begun = bench.begin(kWindow, t_ns, 0, exposed);
    std::shared_ptr<const Scene> ready, scene;
    const auto deadline = steady_clock::now() + std::chrono::seconds(20);
    while ((scene = bench.scene(begun, ready, deadline, stop.get_token())) != ready) ready = scene;
    bench.note_sent(std::uint64_t(++number), t_ns, *ready);
    return ready;
  }

  std::stop_source stop;
  Bench bench{parse_config(R"({"modulator": "dmd", "dmd": {"slots": 4, "cycle_ms": 16},
      "slm": {"width": 640, "height": 384}, "optics": {"focal_length_mm": 100},
      "sensor": {"pupil_diameter_px": 384, "spacing": 0.5}})")
                  .value()};
  int number = 0;
  std::jthread worker{[this](const std::stop_token& token) { bench.work(token); }};
};

TEST_F(PatternBench, ASceneHasAllPatternsOfOneDisplayImage) {
  const Patterns first = stripes(3), second = stripes(9);
  // In the middle of a future cycle, so that a busy machine changes nothing.
  const std::int64_t now_ns = utc_ns(), before_ns = bench.clock()->next_cycle(now_ns + kSecondNs);
  const std::int64_t cycle_ns = before_ns + 4 * kPeriodNs;
  const auto shown_at = steady_clock::now() + std::chrono::nanoseconds(before_ns - now_ns) +
                        std::chrono::nanoseconds(2 * kPeriodNs);
  bench.show(first, shown_at);
  bench.show(second, shown_at + milliseconds(16));
  const auto crc_of = [](const Image<std::uint8_t>& image) {
    return std::uint32_t(::crc32(0, image.pixels.data(), uInt(image.pixels.size())));
  };
  EXPECT_EQ(frame(cycle_ns - kPeriodNs)->patterns[3].crc32,
            crc_of(Image<std::uint8_t>(kWidth, kHeight)))
      << "an image takes effect at the begin of a cycle";
  std::set<std::vector<float>> lights;
  for (int n = 0; n < 8; ++n) {
    const auto scene = frame(cycle_ns + n * kPeriodNs);
    ASSERT_EQ(scene->patterns.size(), 4U);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(scene->patterns[k].crc32, crc_of((n < 4 ? first : second)[k])) << n;
      lights.insert(scene->patterns[k].intensity->pixels);
    }
  }
  EXPECT_EQ(lights.size(), 8U);
  EXPECT_EQ(bench.status().far_fields, 3U * 4U) << "each is computed once";
  const auto sent = bench.frame_truths();
  ASSERT_EQ(sent.size(), 9U);
  for (std::size_t n = 0; n < 8; ++n) {
    EXPECT_EQ(sent[n + 1].pattern, int(n % 4));
    EXPECT_EQ(sent[n + 1].crc32, crc_of((n < 4 ? first : second)[n % 4]));
  }
}

TEST_F(PatternBench, WithTurbulenceAFrameHasTheLightOfItsPattern) {
  Truth truth = bench.truth();
  truth.turbulence.emplace();
  bench.set_truth(truth);
  const std::int64_t cycle_ns = bench.clock()->next_cycle(utc_ns());
  for (int n = 0; n < 5; ++n) {
    const auto scene = frame(cycle_ns + n * kPeriodNs);
    EXPECT_EQ(scene->t_ns, cycle_ns + n * kPeriodNs);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(scene->patterns[k].intensity != nullptr, int(k) == n % 4) << n;
    }
  }
}

TEST_F(PatternBench, TruthsAfterAFrameNumberAreGivenInOrder) {
  const auto scene = frame(bench.clock()->next_cycle(utc_ns()));
  constexpr int kFrames = 20'000, kFirst = 60'000;  // numbers begin again after 65535
  const auto id = [](int n) { return std::uint64_t((kFirst + n) % 65535 + 1); };
  for (int n = 0; n < kFrames; ++n) bench.note_sent(id(n), kNowNs + n, *scene);
  EXPECT_EQ(bench.frame_truths().size(), 32U);
  EXPECT_EQ(bench.frame_truths().back().frame_id, id(kFrames - 1));
  int after = kFrames - 10'000, found = 0;
  for (auto truths = bench.frame_truths(int(id(after))); !truths.empty();
       truths = bench.frame_truths(int(id(after)))) {
    for (const FrameTruth& one : truths) EXPECT_EQ(one.frame_id, id(++after));
    found += int(truths.size());
  }
  EXPECT_EQ(found, 9'999);
  EXPECT_TRUE(bench.frame_truths(int(id(kFrames + 5))).empty());
}

/// Frames without noise, or of a pool, of a scene whose pattern k has the intensity k + 1.
class PatternFrames : public ::testing::Test {
 protected:
  FrameRequest request(Noise noise, const Exposed& exposed) {
    if (scene->truth.noise != noise) {
      auto changed = std::make_shared<Scene>(*scene);
      changed->truth.noise = noise;
      scene = changed;
    }
    FrameRequest result;
    result.scene = scene;
    result.exposed = exposed;
    result.exposure_us = kReferenceExposureUs;
    return result;
  }
  std::vector<std::byte> take(const FrameRequest& wanted) {
    std::vector<std::byte> out(frame_bytes(wanted.format, kSize, kSize));
    const auto deadline = steady_clock::now() + std::chrono::seconds(20);
    EXPECT_TRUE(source.take(wanted, deadline, stop.get_token(), out));
    return out;
  }
  static std::shared_ptr<Scene> four_levels() {
    auto result = std::make_shared<Scene>();
    for (int k = 0; k < 4; ++k) {
      result->patterns.push_back({std::make_shared<Image<float>>(kSize, kSize, float(k + 1))});
    }
    result->truth.peak_electrons = 1000.0;
    result->truth.detector.prnu = 0.0;
    result->truth.detector.black_level_dn = 0.0;
    return result;
  }

  static constexpr int kSize = 64;
  std::shared_ptr<const Scene> scene = four_levels();
  FrameSource source{632.0};
  std::stop_source stop;
  std::jthread worker{[this](const std::stop_token& s) { source.work(s); }};
};

TEST_F(PatternFrames, ShowTheirPatternOrTheMeanOfSeveral) {
  const auto level = [&](Exposed exposed) { return int(take(request(Noise::none, exposed))[0]); };
  for (int round = 0; round < 3; ++round) {
    for (int k = 0; k < 4; ++k) EXPECT_EQ(level({k, 1}), std::lround(25.5 * (k + 1))) << k;
  }
  EXPECT_EQ(level({0, 4}), std::lround(25.5 * 2.5));
  EXPECT_EQ(level({3, 2}), std::lround(25.5 * 2.5));  // patterns 3 and 0
  EXPECT_EQ(level({1, 2}), std::lround(25.5 * 2.5));
  EXPECT_EQ(source.counts().fresh, 4U + 3U) << "each is digitised once";
}

TEST_F(PatternFrames, ComeFromAPoolOfEachPattern) {
  std::map<int, std::set<std::vector<std::byte>>> seen;
  for (int n = 0; n < 4 * 200; ++n) {
    const int k = n % 4;
    const auto frame = take(request(Noise::pool, {k, 1}));
    EXPECT_NEAR(int(frame[0]), 25.5 * (k + 1), 12.0);
    seen[k].insert(frame);
  }
  std::set<std::vector<std::byte>> all;
  for (const auto& [k, frames] : seen) {
    EXPECT_GT(frames.size(), 1U) << k;
    EXPECT_LE(frames.size(), 32U) << k;
    all.insert(frames.begin(), frames.end());
  }
  EXPECT_EQ(source.counts().fresh, all.size()) << "no pool was thrown away";
}

TEST_F(PatternFrames, OfAnotherSceneShowNothingOfTheOneBefore) {
  for (int n = 0; n < 8; ++n) take(request(Noise::fresh, {n % 4, 1}));
  auto bright = std::make_shared<Scene>(*scene);
  for (PatternLight& light : bright->patterns) {
    light.intensity = std::make_shared<Image<float>>(kSize, kSize, 8.0F);
  }
  scene = bright;
  for (int n = 0; n < 8; ++n) EXPECT_GT(int(take(request(Noise::fresh, {n % 4, 1}))[0]), 180);
}

}  // namespace
}  // namespace ovws::twin
