/// The phase of grey levels, measured through the far field and a noisy camera, against the truth.
#include "core/optics/phase_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/optics/detector.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/grey_fringe.hpp"

namespace ovws {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

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

std::vector<GreyBeat> ideal_beats(const Phases& phases, int count, double noise = 0.0) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const std::complex<double> middle{120.0, -40.0}, radius = std::polar(300.0, 1.1);
  std::vector<GreyBeat> beats;
  for (const int g : levels(count)) {
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
    if (wanted > truth.back()) continue;
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
    return reading.beat;
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

TEST(PhaseResponse, RefusesWhatNoTableCanMend) {
  Phases falling = gamma_curve(1.0, 1.0);
  for (std::size_t g = 128; g < 180; ++g) falling[g] -= 0.015 * double(g - 127);
  for (std::size_t g = 180; g < 256; ++g) falling[g] = falling[179] + 0.03 * double(g - 179);
  falling[160] = falling[128] - 0.5;
  const auto found = phase_response(ideal_beats(falling, 256));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::refused);
  EXPECT_NE(found.error().reason.find("the phase falls by"), std::string::npos);
  EXPECT_NE(found.error().reason.find("to 160"), std::string::npos) << found.error().reason;

  const auto noisy = phase_response(ideal_beats(gamma_curve(1.0, 1.0), 33, 100.0));
  EXPECT_FALSE(noisy);
  const auto dead = phase_response(ideal_beats(gamma_curve(0.05, 1.0), 33, 0.01));
  ASSERT_FALSE(dead);
  EXPECT_NE(dead.error().reason.find("only"), std::string::npos) << dead.error().reason;
}

TEST(LinearisingLut, IsWithinHalfALevelOfEveryPhaseInReach) {
  for (const double depth : {0.7, 0.9, 1.0, 1.2, 2.0}) {
    const Phases truth = gamma_curve(depth, 1.4);
    const PhaseTable table = linearising_lut(truth);
    double coarsest = 0.0;
    for (std::size_t g = 1; g < 256; ++g) coarsest = std::max(coarsest, truth[g] - truth[g - 1]);
    for (std::size_t k = 0; k < 256; ++k) {
      const double wanted = kTwoPi * double(k) / 256.0;
      const double off = std::abs(std::remainder(truth[table.lut[k]] - wanted, kTwoPi));
      if (wanted <= truth.back()) {
        EXPECT_LE(off, 0.5 * coarsest + 1e-9) << depth << " " << k;
      } else {
        EXPECT_LE(off, 0.5 * (kTwoPi - truth.back()) + 1e-9) << depth << " " << k;
      }
    }
    EXPECT_EQ(table.reason.empty(), depth >= 1.0) << table.reason;
    EXPECT_EQ(table.steps_out_of_reach > 0, depth < 1.0);
  }
}

TEST(GreyFringe, TellsThePhaseThroughANoisyCamera) {
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

}  // namespace
}  // namespace ovws
