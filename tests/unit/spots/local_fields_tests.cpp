/// A bench whose light is uneven and partly cut off: what the model learns of it from a reference.
#include <complex>
#include <cstdio>
#include <numbers>

#include "core/optics/hologram.hpp"
#include "core/spots/measured_spots.hpp"
#include "tests/unit/spots/templates_case.hpp"

namespace ovws {
namespace {

/// Gaussian light with 1/e^2 at the pupil's edge; a subaperture right of the middle is half dark.
class UnevenBench {
 public:
  UnevenBench()
      : renderer_(HologramRenderer::make({}).value()),
        far_field_(SlmGeometry{}, far_field_window(sensor_of(1), {}, {}, kImagePx, kImagePx)) {}

  /// Electrons, `peak_e` for a flat wavefront.
  Image<float> light(const Waves& waves, double peak_e) {
    if (!(level_ > 0.0)) {
      const Image<float> flat = intensity({});
      level_ = 1.0 / double(*std::max_element(flat.pixels.begin(), flat.pixels.end()));
    }
    Image<float> image = intensity(waves);
    scale(image, level_ * peak_e);
    return image;
  }

 private:
  static double amplitude(double x, double y) {
    constexpr double kRadiusPx = 384.0, kPitchPx = 2.0 * kRadiusPx / 5.0;
    if (std::hypot(x - 3.0 * kPitchPx, y) < kPitchPx) return 0.0;
    return std::exp(-(x * x + y * y) / (kRadiusPx * kRadiusPx));
  }

  Image<float> intensity(const Waves& waves) {
    std::vector<Mode> modes;
    for (std::size_t k = 0; k < waves.size(); ++k) modes.push_back({int(k) + 1, waves[k]});
    Image<std::uint8_t> grey;
    renderer_.render(HologramKind::sensor, modes, grey);
    Image<std::complex<float>> field(grey.width, grey.height), far;
    for (int y = 0; y < grey.height; ++y) {
      for (int x = 0; x < grey.width; ++x) {
        const double turns = grey.at(x, y) / 256.0;
        field.at(x, y) = std::complex<float>(
            std::polar(amplitude(x - 0.5 * (grey.width - 1), y - 0.5 * (grey.height - 1)),
                       2.0 * std::numbers::pi * turns));
      }
    }
    far_field_.propagate(field, far);
    Image<float> light(far.width, far.height);
    std::transform(far.pixels.begin(), far.pixels.end(), light.pixels.begin(),
                   [](std::complex<float> value) { return std::norm(value); });
    return light;
  }

  HologramRenderer renderer_;
  FarField far_field_;
  double level_ = 0.0;
};

class LocalFields : public Templates {
 public:
  /// What a calibration measures about the wavefront `resting`, without noise.
  static MeasuredShapes calibrated(UnevenBench& bench, const Waves& resting, double peak_e) {
    const int modes = int(resting.size());
    std::vector<SpotWindow> windows;
    std::vector<Vec2> places_px;
    for (const RenderedSpot& spot : renderer(1, modes, 0.0).render(resting)) {
      windows.push_back(spot.window);
      places_px.push_back(spot.place_px);
    }
    const auto cells = [&](const Waves& waves) {
      return cells_in(bench.light(waves, peak_e), windows);
    };
    std::vector<PokedSpots> pokes;
    MeasuredShapes shapes{first_modes(modes), {}};
    for (std::size_t k = 0; k < resting.size(); ++k) {
      const double poke = k % 3 == 0 ? 0.015 : 0.03;  // some modes were poked by less
      Waves plus = resting, minus = resting;
      plus[k] += poke, minus[k] -= poke;
      pokes.push_back({poke, cells(plus), cells(minus)});
      shapes.poke_waves.push_back(poke);
    }
    shapes.spots = measured_spots(windows, places_px, cells(resting), pokes);
    return shapes;
  }
};

TEST_F(LocalFields, OfUnevenAndCutLightAreLearnedFromTheReference) {
  constexpr double kPeak = 4000.0;
  UnevenBench bench;
  const PixelNoise noise{25.0, 1.0};
  for (const int modes : {18, 44}) {
    const Waves flat(std::size_t(modes), 0.0);
    PointModel points(renderer(1, modes, 0.0), 8);
    const auto reference = exposed(bench.light(flat, kPeak), kReadNoiseE, 1);
    const auto used = points.use_reference(view(reference), noise, flat, {});
    ASSERT_TRUE(used) << used.error().reason;
    for (const double rms : {0.0, 0.05, 0.1}) {
      const Waves truth = rms > 0.0 ? random(modes, rms, 5) : flat;
      const auto image = exposed(bench.light(truth, kPeak), kReadNoiseE, 2);
      const auto fit = points.templates(view(image), noise, std::vector<Waves>{flat}, {}, 8);
      ASSERT_TRUE(fit) << modes << " modes, " << rms << " wave: " << fit.error().reason;
      const Frame frame = measured(**fit, view(image));
      std::printf("  %d modes, %.2f wave: error %.5f wave, %d lost\n", modes, rms,
                  error(frame.waves, truth), frame.fitted.lost);
      EXPECT_LE(frame.fitted.lost, 1);
      EXPECT_LT(error(frame.waves, truth), modes == 18 ? 0.004 : 0.01);
    }
  }
}

/// The calibration was taken 0.005 wave from the reference. At 0.02 wave the gain is less.
TEST_F(LocalFields, ACalibrationCorrectsRenderingsNearIt) {
  constexpr int kModes = 44;
  constexpr double kPeak = 20000.0;
  UnevenBench bench;
  const PixelNoise noise{25.0, 1.0};
  const Waves flat(kModes, 0.0), resting = random(kModes, 0.005, 8);
  PointModel points(renderer(1, kModes, 0.0), 8);
  const auto reference = exposed(bench.light(flat, kPeak), kReadNoiseE, 1);
  ASSERT_TRUE(points.use_reference(view(reference), noise, flat, {}));
  const std::array rms_waves{0.0, 0.05, 0.1, 0.3};
  const auto errors = [&] {
    std::vector<double> all;
    for (const double rms : rms_waves) {
      const Waves truth = rms > 0.0 ? random(kModes, rms, 5) : flat;
      const auto image = exposed(bench.light(truth, kPeak), kReadNoiseE, 2);
      const auto fit = points.templates(view(image), noise, std::vector<Waves>{flat}, {}, 8);
      EXPECT_TRUE(fit) << rms;
      all.push_back(fit ? error(measured(**fit, view(image)).waves, truth) : NAN);
    }
    return all;
  };
  const auto rendered = errors();
  points.correct_by(calibrated(bench, resting, kPeak), resting);
  const auto corrected = errors();
  for (std::size_t k = 0; k < rms_waves.size(); ++k) {
    std::printf("  %.2f wave: error %.5f wave, corrected %.5f\n", rms_waves[k], rendered[k],
                corrected[k]);
  }
  EXPECT_LT(corrected[0], 0.001);
  EXPECT_LT(corrected[1], std::min(0.002, 0.7 * rendered[1]));
  EXPECT_LT(corrected[2], std::min(0.0045, 0.9 * rendered[2]));
  EXPECT_LT(corrected[3], 1.2 * rendered[3]);
  points.end_correction();
  EXPECT_EQ(errors(), rendered);
}

}  // namespace
}  // namespace ovws
