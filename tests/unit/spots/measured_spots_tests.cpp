/// Templates that pokes measured, without a model of the bench.
#include <cstdio>

#include "core/spots/measured_model.hpp"
#include "core/spots/measured_spots.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

constexpr double kPokeWaves = 0.03;
constexpr double kCalibratedPeakE = 5000.0;  // as a mean of frames

struct Measured : Templates {
  /// Mean image of the calibration, DN.
  static Image<float> mean_image(const Waves& waves) { return light(1, waves, kCalibratedPeakE); }

  static std::vector<SpotWindow> windows(int modes) {
    std::vector<SpotWindow> all;
    for (const RenderedSpot& spot : renderer(1, modes, 0.0).render(Waves(modes, 0.0))) {
      all.push_back(spot.window);
    }
    return all;
  }

  static std::vector<RenderedSpot> calibrated(int modes, const Waves& resting) {
    const auto all = windows(modes);
    std::vector<PokedSpots> pokes;
    for (int k = 0; k < modes; ++k) {
      Waves plus = resting, minus = resting;
      plus[k] += kPokeWaves, minus[k] -= kPokeWaves;
      pokes.push_back(
          {kPokeWaves, cells_in(mean_image(plus), all), cells_in(mean_image(minus), all)});
    }
    return measured_spots(all, model(1).spots_px(), cells_in(mean_image(resting), all), pokes);
  }
};

TEST_F(Measured, TemplatesCountFromTheCalibrationUntilThereIsAReference) {
  const Waves resting = random(18, 0.05, 1), away = random(18, 0.02, 2);
  const MeasuredModel measured(calibrated(18, resting), first_modes(18), kMaxSpotEstimates);
  Waves waves = resting;
  for (std::size_t k = 0; k < waves.size(); ++k) waves[k] += away[k];
  const auto image = exposed(light(1, waves), kReadNoiseE, 1);
  const auto fit = measured.templates(std::vector{view(image)});
  ASSERT_TRUE(fit) << fit.error().reason;
  const auto read = (*fit)->measure(view(image)).coefficients;
  EXPECT_LT(error(Eigen::Map<const Eigen::VectorXf>(read.data(), 18).cast<double>(), away), 0.006);
}

TEST_F(Measured, TemplatesReadWavefrontsNearTheCalibration) {
  for (const int modes : {18, 44}) {
    const Waves resting = random(modes, 0.05, 1);
    MeasuredModel measured(calibrated(modes, resting), first_modes(modes), kMaxSpotEstimates);
    const auto at_rest = [&](unsigned seed) {
      return exposed(light(1, resting), kReadNoiseE, seed);
    };
    const auto first = at_rest(1), second = at_rest(2);
    const std::vector<ImageView> images{view(first), view(second)};
    ASSERT_TRUE(measured.use_reference(images[0], {25.0, 1.0}));
    const auto fit = measured.templates(images);
    ASSERT_TRUE(fit) << fit.error().reason;
    for (const double rms : {0.0, 0.01, 0.03}) {
      const Waves away = random(modes, rms, 2);
      Waves waves = resting;
      for (int k = 0; k < modes; ++k) waves[k] += away[k];
      const auto image = exposed(light(1, waves), kReadNoiseE, 3);
      auto pixels = (*fit)->spots().make_scratch();
      std::vector<SpotEstimates> found;
      for (std::size_t i = 0; i < 19; ++i)
        found.push_back((*fit)->spots().fit(view(image), i, pixels));
      auto scratch = (*fit)->make_scratch();
      std::vector<float> coefficients(modes), sigma(modes);
      std::vector<SpotFix> fixes(19);
      EXPECT_TRUE((*fit)->solve(found, scratch, coefficients, sigma, fixes).credible);
      const Eigen::VectorXd read =
          Eigen::Map<Eigen::VectorXf>(coefficients.data(), modes).cast<double>();
      const double off = error(read, away);
      std::printf("  %d modes, %.2f wave from the calibration: error %.5f wave\n", modes, rms, off);
      EXPECT_LT(off, 0.004 + 0.05 * rms);
    }
  }
}

TEST_F(Measured, PositionsAreFoundByTheGradientOfTheLight) {
  const auto all = windows(18);
  const Waves flat(18, 0.0);
  const auto spots = measured_spots(all, model(1).spots_px(), cells_in(mean_image(flat), all), {});
  Waves tilted = flat;
  tilted[0] = 0.02, tilted[1] = -0.01;
  const auto moved = renderer(1, 18).render(tilted);
  const auto image = exposed(light(1, tilted, kCalibratedPeakE), kReadNoiseE, 1);
  const SpotPass pass = fit_spots(view(image), spots, {25.0, 1.0}, 2);
  const auto still = renderer(1, 18).render(flat);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 shift = moved[i].place_px - still[i].place_px;
    EXPECT_NEAR(double(pass.found[i].x) - spots[i].place_px.x, shift.x, 0.02);
    EXPECT_NEAR(double(pass.found[i].y) - spots[i].place_px.y, shift.y, 0.02);
  }
}

TEST_F(Measured, ASaturatedSpotHasNoLight) {
  const auto all = windows(18);
  Image<float> image = mean_image(Waves(18, 0.0));
  image.row(all[3].top + 5)[all[3].left + 5] = NAN;
  const auto spots = measured_spots(all, model(1).spots_px(), cells_in(image, all), {});
  EXPECT_EQ(spots[3].light.maxCoeff(), 0.0F);
  EXPECT_GT(spots[4].light.maxCoeff(), 0.1F);
}

}  // namespace
}  // namespace ovws
