/// The SLM phase response, measured through the far field and a noisy camera, against the truth.
#include "core/optics/phase_response.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "core/base/angle.hpp"
#include "core/optics/detector.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/grey_fringe.hpp"

namespace ovws {
namespace {

using Phases = std::array<double, 256>;

Phases gamma_curve(double depth_waves, double gamma) {
  Phases phases{};
  for (int g = 0; g < 256; ++g) {
    phases[std::size_t(g)] = kTwoPi * depth_waves * std::pow(g / 256.0, gamma);
  }
  return phases;
}

std::vector<int> levels(int count) {
  std::vector<int> greys;
  for (int k = 0; k < count; ++k) greys.push_back(int(std::lround(255.0 * k / (count - 1))));
  return greys;
}

std::vector<GreyBeat> ideal_beats(const Phases& phases, const std::vector<int>& greys, double noise,
                                  unsigned seed = 3) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const std::complex<double> middle{120.0, -40.0}, radius = std::polar(300.0, 1.1);
  std::vector<GreyBeat> beats;
  for (const int g : greys) {
    const auto seen = [&] {
      const double re = normal(random), im = normal(random);
      return middle + radius * std::polar(1.0, phases[std::size_t(g)]) +
             noise * std::complex<double>(re, im);
    };
    const auto first = seen();
    beats.push_back({g, first, seen()});
  }
  return beats;
}

std::vector<GreyBeat> ideal_beats(const Phases& phases, int count, double noise = 0.0) {
  return ideal_beats(phases, levels(count), noise);
}

/// And the levels between, all in one sweep as lut.run measures them.
std::vector<GreyBeat> refined_beats(const Phases& phases, int count, double noise) {
  std::vector<int> greys = levels(count);
  for (unsigned seed = 3;; ++seed) {
    const auto beats = ideal_beats(phases, greys, noise, seed);
    const auto more = levels_between(beats);
    EXPECT_TRUE(more);
    if (!more || more->empty()) return beats;
    greys.insert(greys.end(), more->begin(), more->end());
    std::ranges::sort(greys);
  }
}

double rms_error(const Phases& found, const Phases& truth) {
  double sum = 0.0;
  for (std::size_t g = 0; g < 256; ++g) {
    sum += std::pow(found[g] - (truth[g] - truth[0]), 2);
  }
  return std::sqrt(sum / 256.0);
}

/// How far the phase shown is from the one wanted, RMS over the steps in reach, free of piston.
double lut_error_rad(const PhaseLut& lut, const Phases& truth) {
  double mean = 0.0, square = 0.0;
  int n = 0;
  for (std::size_t k = 0; k < 256; ++k) {
    const double wanted = kTwoPi * double(k) / 256.0;
    const double turned = truth.back() > 0.0 || k == 0 ? wanted : kTwoPi - wanted;
    if (turned > std::abs(truth.back())) continue;
    const double off = std::remainder(truth[lut[k]] - wanted, kTwoPi);
    mean += off;
    square += off * off;
    ++n;
  }
  mean /= n;
  return std::sqrt(square / n - mean * mean);
}

/// An SLM of this response before a camera of 8 bits, a window of it around the base spot.
class Bench {
 public:
  explicit Bench(const Phases& phases, PxPerCycle map = 1928.3)
      : phases_(phases),
        map_(map),
        patches_(fringe_patches(sensor_, map, 0.5)),
        far_field_(slm_, window()),
        detector_(DetectorConfig{}, kSize, kSize) {}

  std::complex<double> beat(int grey, int fixed) {
    draw_fringe_patches(patches_, sensor_, slm_, grey, fixed, grey_);
    return look().beat;
  }

  double blazed_dn(const PhaseLut& lut) {
    draw_blazed_patch(patches_, sensor_, slm_, lut, grey_);
    return look().brightest_dn;
  }

  std::vector<GreyBeat> sweep(int count, int fixed) {
    std::vector<GreyBeat> beats;
    for (const int g : levels(count)) {
      const auto first = beat(g, fixed);
      beats.push_back({g, first, beat(g, fixed)});
    }
    return beats;
  }

 private:
  /// What the camera sees of grey_.
  FringeReading look() {
    Image<std::complex<float>> field(slm_.width_px, slm_.height_px), far;
    for (std::size_t i = 0; i < field.pixels.size(); ++i) {
      field.pixels[i] = std::complex<float>(std::polar(1.0, phases_[grey_.pixels[i]]));
    }
    far_field_.propagate(field, far);
    Image<float> photons(kSize, kSize);
    // The brightest pixel of both patches' light, at a phase of pi, is 0.9 of the full well.
    const double area = 0.25 * std::numbers::pi * patches_.diameter_px * patches_.diameter_px;
    const double peak = std::pow(2.0 * area * 2.0 / std::numbers::pi, 2);
    for (std::size_t i = 0; i < far.pixels.size(); ++i) {
      photons.pixels[i] = float(9000.0 / 0.6 * std::norm(far.pixels[i]) / peak);
    }
    Image<std::uint16_t> dn;
    detector_.expose(photons, 2000.0, 0.0, dn);
    Image<float> light(kSize, kSize);
    std::copy(dn.pixels.begin(), dn.pixels.end(), light.pixels.begin());
    const auto reading = read_fringe(light, patches_, {0.5 * (kSize - 1), 0.5 * (kSize - 1)}, map_);
    EXPECT_FALSE(reading.saturated);
    return reading;
  }

  static constexpr int kSize = 128;
  FarFieldWindow window() const {
    return far_field_window(sensor_, slm_, OpticsConfig{}, kSize, kSize);
  }

  Phases phases_;
  SlmGeometry slm_;
  SensorConfig sensor_;
  PxPerCycle map_;
  FringePatches patches_;
  FarField far_field_;
  Detector detector_;
  Image<std::uint8_t> grey_;
};

TEST(GreyFringe, TellsTheRotationOfTheCamera) {
  const double scale = 1928.3;
  const FringePatches patches = fringe_patches(SensorConfig{}, scale, 0.5);
  constexpr int kSide = 128;
  const Vec2 base{60.0, 66.5};
  const auto dot = [](Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; };
  for (const double degrees : {0.0, 30.0, 117.0, 179.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vec2 per_px = patches.distance_px / scale * Vec2{std::cos(angle), std::sin(angle)};
    Image<float> light(kSide, kSide);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const Vec2 from = Vec2{double(x), double(y)} - base;
        const double fringe =
            1.0 + 0.5 * std::cos(2.0 * std::numbers::pi * dot(from, per_px) + 1.0);
        light.at(x, y) = float(2.0 + 80.0 * std::exp(-dot(from, from) / 200.0) * fringe);
      }
    }
    const PxPerCycle map = find_fringe_rotation(light, patches, base, scale);
    EXPECT_NEAR(map.xx, scale * std::cos(angle), 0.03 * scale) << degrees;
    EXPECT_NEAR(map.yx, scale * std::sin(angle), 0.03 * scale) << degrees;
    EXPECT_NEAR(map.scale(), scale, 1e-6);
  }
}

TEST(PhaseResponse, IsFoundFromIdealBeatsWhateverTheCurve) {
  for (const double depth : {0.4, 0.9, 1.0, 1.2, 2.5}) {
    for (const double gamma : {0.8, 1.0, 1.4, 2.0}) {
      const Phases truth = gamma_curve(depth, gamma);
      const auto found = phase_response(ideal_beats(truth, 33));
      ASSERT_TRUE(found) << depth << " " << gamma << ": " << found.error().reason;
      EXPECT_LT(rms_error(found->phase_rad, truth), 0.01) << depth << " " << gamma;
    }
  }
}

TEST(PhaseResponse, SaysHowWellItIsKnown) {
  const Phases truth = gamma_curve(1.1, 1.2);
  const auto found = phase_response(ideal_beats(truth, 33, 9.0));  // 0.03 rad a reading
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_NEAR(found->noise_rad, 0.03 / std::sqrt(2.0), 0.008);
  const double error = rms_error(found->phase_rad, truth);
  EXPECT_LT(error, 2.0 * found->noise_rad);
  double claimed = 0.0;
  for (const double se : found->standard_error_rad) claimed += se * se / 256.0;
  EXPECT_LT(std::sqrt(claimed), 1.5 * found->noise_rad);
  EXPECT_GT(std::sqrt(claimed), 0.2 * found->noise_rad);
}

/// A response that rises by a tenth of a turn from grey level 0 to 1: the levels between are
/// measured where it is steep.
TEST(PhaseResponse, OfASteepBeginningIsAsGoodAsItSays) {
  for (const double gamma : {0.4, 0.5, 3.0}) {
    const Phases truth = gamma_curve(1.1, gamma);
    for (const double noise : {0.3, 3.0}) {  // 1 and 10 mrad a reading
      const auto coarse = phase_response(ideal_beats(truth, 33, noise));
      const auto found = phase_response(refined_beats(truth, 33, noise));
      ASSERT_TRUE(found) << found.error().reason;
      const double error = rms_error(found->phase_rad, truth);
      const double table = lut_error_rad(linearising_lut(found->phase_rad).lut, truth);
      const double best = lut_error_rad(linearising_lut(truth).lut, truth);
      double largest = 0.0, claimed = 0.0;
      for (std::size_t g = 0; g < 256; ++g) {
        const double off = std::abs(found->phase_rad[g] - truth[g]);
        if (g > 0) largest = std::max(largest, off / found->standard_error_rad[g]);
        claimed += std::pow(found->standard_error_rad[g], 2) / 256.0;
      }
      std::printf(
          "gamma %.1f: %d levels, response %.4f rad, says %.4f, largest %.1f times; "
          "33 levels only: %.4f rad; table %.4f rad (best %.4f)\n",
          gamma, found->levels, error, std::sqrt(claimed), largest,
          coarse ? rms_error(coarse->phase_rad, truth) : -1.0, table, best);
      // Grey level 0, from which all is counted, is known to 0.7 mrad, or 7, itself.
      EXPECT_LT(error, noise < 1.0 ? 0.004 : 0.02);
      EXPECT_LT(error, 3.0 * std::sqrt(claimed));
      EXPECT_LT(std::sqrt(claimed), 3.0 * found->noise_rad);
      EXPECT_LT(largest, 6.0);
      EXPECT_LT(table, best + 0.003);
    }
  }
}

TEST(PhaseResponse, IsThatOfAnSlmSeenInAnyDirection) {
  Phases truth = gamma_curve(0.9, 1.4);
  std::vector<GreyBeat> beats = ideal_beats(truth, 17);
  for (GreyBeat& beat : beats) {
    beat.first = std::conj(beat.first);
    beat.second = std::conj(beat.second);
  }
  const auto found = phase_response(beats);
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_LT(rms_error(found->phase_rad, truth), 0.01);
}

TEST(PhaseResponse, RefusesAPhaseThatReversesIsNoisyOrTooShallow) {
  Phases falling = gamma_curve(1.0, 1.0);
  for (std::size_t g = 128; g < 180; ++g) falling[g] -= 0.015 * double(g - 127);
  for (std::size_t g = 180; g < 256; ++g) falling[g] = falling[179] + 0.03 * double(g - 179);
  falling[160] = falling[128] - 0.5;
  const auto found = phase_response(ideal_beats(falling, 256));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::refused);
  EXPECT_NE(found.error().reason.find("it reverses by"), std::string::npos);
  EXPECT_NE(found.error().reason.find("to 160"), std::string::npos) << found.error().reason;

  const auto noisy = phase_response(ideal_beats(gamma_curve(1.0, 1.0), 33, 100.0));
  ASSERT_FALSE(noisy);
  EXPECT_NE(noisy.error().reason.find("bright enough"), std::string::npos);
  const auto dead = phase_response(ideal_beats(gamma_curve(0.05, 1.0), 33, 0.01));
  ASSERT_FALSE(dead);
  EXPECT_NE(dead.error().reason.find("only"), std::string::npos) << dead.error().reason;
}

/// The sign is found by a blazed grating, and by nothing else: the beats of both are alike.
TEST(PhaseResponse, OfAnSlmWhosePhaseFallsIsFoundFalling) {
  for (const double depth : {0.9, -0.25, -1.2}) {
    const Phases truth = gamma_curve(depth, 1.4);
    Bench bench(truth);
    const auto rising = phase_response(bench.sweep(13, 200));
    ASSERT_TRUE(rising) << rising.error().reason;
    EXPECT_FALSE(rising->falls());
    const auto table_of = [&](double sign) {
      return linearising_lut(sign > 0.0 ? rising->phase_rad : negative(rising->phase_rad)).lut;
    };
    const BlazedLight up{bench.blazed_dn(table_of(1.0)), bench.blazed_dn(table_of(1.0))};
    const BlazedLight down{bench.blazed_dn(table_of(-1.0)), bench.blazed_dn(table_of(-1.0))};
    const auto found = with_sign(*rising, up, down);
    ASSERT_TRUE(found) << depth << ": " << found.error().reason;
    std::printf("depth %.2f waves: %.0f DN if it rises, %.0f if it falls\n", depth, up.first_dn,
                down.first_dn);
    EXPECT_EQ(found->falls(), depth < 0.0);
    EXPECT_LT(rms_error(found->phase_rad, truth), 0.03) << depth;
    EXPECT_LT(lut_error_rad(linearising_lut(found->phase_rad).lut, truth), 0.03) << depth;
  }
}

/// Each hologram is exposed while the previous one is still shown.
TEST(PhaseResponse, OfAnSlmSlowerThanItsSettleTimeIsRefusedWithThatReason) {
  const auto seen = ideal_beats(gamma_curve(1.0, 1.0), 33);
  auto late = seen;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    late[k].first = seen[k == 0 ? 0 : k - 1].first;
    late[k].second = seen[k + 1 == seen.size() ? k : k + 1].second;
  }
  const auto refused = phase_response(late);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "slm.settle_ms") << refused.error().reason;
  EXPECT_NE(refused.error().reason.find("slm.settle measures"), std::string::npos);
}

TEST(PhaseResponse, IsRefusedWhereItsSignDoesNotShow) {
  const auto rising = phase_response(ideal_beats(gamma_curve(1.0, 1.0), 33));
  ASSERT_TRUE(rising);
  for (const BlazedLight& falling : {BlazedLight{101.0, 102.0}, BlazedLight{60.0, 90.0}}) {
    const auto unknown = with_sign(*rising, {100.0, 101.0}, falling);
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, Errc::refused);
    EXPECT_NE(unknown.error().reason.find("rises or falls"), std::string::npos);
  }
  EXPECT_FALSE(with_sign(*rising, {100.0, 101.0}, {60.0, 61.0})->falls());
  EXPECT_TRUE(with_sign(*rising, {60.0, 61.0}, {100.0, 101.0})->falls());
}

TEST(LinearisingLut, IsWithinHalfALevelOfEveryPhaseInReach) {
  for (const double depth : {0.7, 0.9, 1.0, 1.2, 2.0, -0.7, -1.0, -2.0}) {
    const Phases truth = gamma_curve(depth, 1.4);
    const PhaseTable table = linearising_lut(truth);
    double coarsest = 0.0;
    for (std::size_t g = 1; g < 256; ++g) {
      coarsest = std::max(coarsest, std::abs(truth[g] - truth[g - 1]));
    }
    for (std::size_t k = 0; k < 256; ++k) {
      const double wanted = kTwoPi * double(k) / 256.0;
      const double off = std::abs(std::remainder(truth[table.lut[k]] - wanted, kTwoPi));
      const double reach = std::abs(truth.back());
      const double turned = depth > 0.0 || k == 0 ? wanted : kTwoPi - wanted;
      if (turned <= reach) {
        EXPECT_LE(off, 0.5 * coarsest + 1e-9) << depth << " " << k;
      } else {
        EXPECT_LE(off, 0.5 * (kTwoPi - reach) + 1e-9) << depth << " " << k;
      }
    }
    EXPECT_EQ(table.reason.empty(), std::abs(depth) >= 1.0) << table.reason;
    EXPECT_EQ(table.steps_out_of_reach > 0, std::abs(depth) < 1.0);
  }
}

TEST(GreyFringe, MeasuresThePhaseThroughANoisyCamera) {
  struct Case {
    double depth, gamma;
  };
  for (const Case slm : {Case{0.9, 1.4}, Case{1.2, 0.8}}) {
    const Phases truth = gamma_curve(slm.depth, slm.gamma);
    const auto found = phase_response(Bench(truth).sweep(13, 144));
    ASSERT_TRUE(found) << found.error().reason;
    const double error = rms_error(found->phase_rad, truth);
    const PhaseTable table = linearising_lut(found->phase_rad);
    const double shown = lut_error_rad(table.lut, truth);
    std::printf("depth %.1f waves, gamma %.1f: response %.4f rad, noise %.4f, table %.4f rad\n",
                slm.depth, slm.gamma, error, found->noise_rad, shown);
    EXPECT_LT(error, 0.02);
    EXPECT_LT(shown, 0.03);
  }
}

/// On the way up the bench moves after the first levels: their second readings are turned.
TEST(PhaseResponse, IsRefusedIfTheBenchMovesMeanwhile) {
  const auto moved = [](double by_rad, double noise) {
    auto beats = ideal_beats(gamma_curve(1.0, 1.0), 33, noise);
    for (std::size_t k = 0; k < 12; ++k) {
      beats[k].second = std::polar(1.0, by_rad) * beats[k].second;
    }
    return phase_response(beats);
  };
  EXPECT_TRUE(moved(0.0, 0.3));
  EXPECT_TRUE(moved(0.005, 0.3)) << "it bends the curve by less than the noise";
  const auto refused = moved(0.1, 0.3);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::refused);
  EXPECT_NE(refused.error().reason.find("moved"), std::string::npos) << refused.error().reason;
  EXPECT_NE(refused.error().reason.find("rad RMS"), std::string::npos) << refused.error().reason;
  // As much, but independent from level to level: the curve averages it.
  EXPECT_TRUE(moved(0.0, 9.0));
}

TEST(PhaseResponse, ImagesThatLagAreRefusedBeforeMoreLevelsAreRequested) {
  const std::complex<double> middle{120.0, -40.0};
  auto beats = ideal_beats(gamma_curve(1.0, 1.0), 33, 0.3);
  for (GreyBeat& beat : beats) {
    beat.second = middle + (beat.second - middle) * std::polar(1.0, 0.4);
  }
  const auto between = levels_between(beats);
  ASSERT_FALSE(between);
  EXPECT_EQ(between.error().field, "slm.settle_ms");
}

}  // namespace
}  // namespace ovws
