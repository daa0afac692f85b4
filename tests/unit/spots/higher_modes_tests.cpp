/// Images of air, which has modes above those that are measured.
#include <cstdio>
#include <utility>

#include "core/optics/kolmogorov.hpp"
#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

constexpr double kBrightE = 2000.0;
constexpr int kMeasuredModes = 44, kLastOfAir = kMaxZernikeIndex, kRenderings = 12;
const PixelNoise kNoise{kReadNoiseE * kReadNoiseE + 1.0 / 12.0, 1.0};

class HigherModes : public Templates {
 public:
  /// Modes from j = 1 on, without tilts, in proportion to Kolmogorov's spectrum.
  static Waves air(double rms, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    Waves waves(2, 0.0);
    double squares = 0.0;
    for (const Mode& mode : air_modes(3, kLastOfAir)) {
      waves.push_back(mode.waves * normal(generator));
      squares += waves.back() * waves.back();
    }
    for (double& w : waves) w *= rms / std::sqrt(squares);
    return waves;
  }
  static PointModel model(int modes) { return {renderer(1, modes, 0.0), kMaxSpotEstimates}; }
};

TEST_F(HigherModes, HaveKolmogorovsSpectrum) {
  const auto modes = air_modes(3, 54);
  ASSERT_EQ(modes.size(), 52U);
  EXPECT_EQ(modes.front().j, 3);
  double sum = 0.0, above_20 = 0.0;
  for (const Mode& mode : modes) {
    sum += mode.waves * mode.waves;
    if (mode.j > 20) above_20 += mode.waves * mode.waves;
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  // Noll, 1976, table IV: an astigmatism 0.0232, a coma 0.00619; 3 modes leave 0.134, 21 leave
  // 0.0208, and the 55 that end here some 0.0092.
  EXPECT_NEAR(std::pow(modes[0].waves / modes[4].waves, 2), 0.0232 / 0.00619, 0.02);
  EXPECT_NEAR(above_20, (0.0208 - 0.0092) / (0.134 - 0.0092), 0.01);
}

struct Errors {
  double error = 0.0, sigma = 0.0;  ///< RMS over images and modes, waves
};

/// 19 vortices in air of this RMS, found from a flat start.
Errors errors_in_air(PointModel& spots, int modes, double rms, double peak_e) {
  constexpr unsigned kImages = 4;
  const Waves flat(modes, 0.0);
  Errors all;
  for (unsigned seed = 1; seed <= kImages; ++seed) {
    const Waves truth = HigherModes::air(rms, seed);
    const auto image = Templates::exposed(Templates::light(1, truth, peak_e), kReadNoiseE, seed);
    const auto fit =
        spots.templates(Templates::view(image), kNoise, std::vector<Waves>{flat}, {}, kRenderings);
    if (!fit) {
      ADD_FAILURE() << fit.error().reason << " at " << rms << " wave, " << modes << " modes";
      continue;
    }
    const auto frame = Templates::measured(**fit, Templates::view(image));
    EXPECT_EQ(frame.allocations, 0U);
    const Waves measured_truth(truth.begin(), truth.begin() + modes);
    all.error += std::pow(Templates::error(frame.waves, measured_truth), 2) / kImages;
    all.sigma += std::pow(Templates::error(frame.sigma, flat), 2) / kImages;
  }
  return {std::sqrt(all.error), std::sqrt(all.sigma)};
}

/// Noise alone would leave 0.0005 wave of 18 modes, and 0.001 of 44, at 2000 e.
TEST_F(HigherModes, AirIsMeasuredWithTheErrorThatTheyCause) {
  for (const auto& [modes, share] : {std::pair(18, 0.35), std::pair(44, 0.65)}) {
    PointModel spots = model(modes);
    for (const double peak_e : {300.0, 2000.0}) {
      for (const double rms : {0.02, 0.05}) {
        const Errors all = errors_in_air(spots, modes, rms, peak_e);
        std::printf("  %d modes, %.0f e, %.2f wave RMS: error %.4f, standard error %.4f\n", modes,
                    peak_e, rms, all.error, all.sigma);
        EXPECT_LT(all.error, share * rms);
        EXPECT_NEAR(all.error / all.sigma, 1.0, 0.4);
      }
    }
  }
}

/// From starts 0.5 wave away some searches end where the spots contradict each other.
TEST_F(HigherModes, ExcuseNoOtherWavefront) {
  for (const auto& [modes, peak_e] :
       {std::pair(kMeasuredModes, kBrightE), {kMeasuredModes, 100.0}, {18, 100.0}}) {
    PointModel spots = model(modes);
    int found = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Waves truth = random(modes, seed % 2 == 0 ? 0.6 : 0.3, seed);
      Waves start = random(modes, 0.5, seed + 100);
      for (std::size_t k = 0; k < start.size(); ++k) start[k] += truth[k];
      const auto image = exposed(light(1, truth, peak_e), kReadNoiseE, seed);
      const auto fit =
          spots.templates(view(image), kNoise, std::vector<Waves>{start}, {}, kRenderings);
      if (!fit) continue;
      ++found;
      const Frame frame = measured(**fit, view(image));
      const double sigma = error(frame.sigma, Waves(modes, 0.0));
      EXPECT_LT(error(frame.waves, truth), std::max(0.01, 3.0 * sigma)) << peak_e << ", " << seed;
      EXPECT_LT(sigma, 0.03);
    }
    EXPECT_GE(found, 3) << peak_e;
  }
}

/// A plan for air finds no other wavefront credible.
TEST_F(HigherModes, DescribeNoOtherWavefront) {
  PointModel spots = model(kMeasuredModes);
  const auto image = exposed(light(1, air(0.03, 1), kBrightE), kReadNoiseE, 1);
  const auto fit = spots.templates(view(image), kNoise,
                                   std::vector<Waves>{Waves(kMeasuredModes, 0.0)}, {}, kRenderings);
  ASSERT_TRUE(fit) << fit.error().reason;
  ASSERT_GT((*fit)->point().higher_waves, 0.0);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Waves other = random(kMeasuredModes, seed % 2 == 0 ? 0.1 : 0.3, seed);
    const double peak_e = seed % 4 < 2 ? kBrightE : 0.5 * kBrightE;
    const auto frame = measured(**fit, view(exposed(light(1, other, peak_e), kReadNoiseE, seed)));
    EXPECT_TRUE(!frame.fitted.credible || error(frame.waves, other) < 0.1) << seed;
  }
}

}  // namespace
}  // namespace ovws
