/// The twin's lenslet array against analytic diffraction patterns and a brute-force Fresnel sum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/spots/spot_renderer.hpp"
#include "drivers/twin/array_layout.hpp"
#include "drivers/twin/array_model.hpp"
#include "drivers/twin/optical_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {
namespace {

constexpr double kPi = std::numbers::pi;
const Image<std::uint8_t> kNoGrey;

/// The camera of most laboratories: 150 um pitch, 5.2 mm focal length, 5.3 um pixels.
Config array_of(const std::string& array, int charge = 0, const std::string& more = "") {
  const auto config = parse_config(
      R"({"modulator": "fixed", "optics": {"focal_length_mm": 5.2, "camera_pitch_um": 5.3,
          "centre_px": [127.3, 128.6]}, "sensor": {"charge": )" +
      std::to_string(charge) + R"(}, "array": )" + array + more + "}");
  if (!config) throw std::runtime_error(text_of(config.error()));
  return *config;
}

Image<float> image_of(const Config& config, const Roi& window = {0, 0, 256, 256}) {
  ArrayModel model(config);
  model.set_window(window, config.truth.geometry);
  return model.intensity(kNoGrey);
}

/// Unit of the intensity: the peak amplitude of an ideal vortex of a round lenslet.
double unit(const Config& config) {
  return kVortexPeak * kPi * config.array.pitch_um * config.array.pitch_um / 4.0;
}

/// Fresnel's integral behind the whole array, sampled at `fine` x `fine` points of each lenslet.
double brute_force(const Config& config, Vec2 px, int fine = 144) {
  const ArrayModel model(config);
  const Vec2 x = model.map(config.truth.geometry).frequency(px);
  const double lambda_f = config.optics.wavelength_nm * config.optics.focal_length_mm;
  const double side = 1.2 * config.array.pitch_um;  // holds a hexagon
  const double step = side / fine, radius = pupil_um(config.array) / 2;
  std::complex<double> sum = 0.0;
  for (const Vec2 c : lenslet_centres(config.array)) {
    for (int k = 0; k < fine * fine; ++k) {
      const Vec2 s{(k % fine + 0.5) * step - side / 2, (k / fine + 0.5) * step - side / 2};
      if (!in_lenslet(config.array, s)) continue;
      const Vec2 r = c + s;
      const double waves = wavefront(config.truth.aberration, (1.0 / radius) * r);
      const double phase = 2.0 * kPi * waves +
                           plate_radians(config.array.plate, config.sensor.charge, s) -
                           kPi * (c.x * c.x + c.y * c.y) / lambda_f -
                           2.0 * kPi * ((x.x - c.x) * r.x + (x.y - c.y) * r.y) / lambda_f;
      sum += std::polar(step * step, phase);
    }
  }
  return std::norm(sum) / (unit(config) * unit(config));
}

/// Largest error of the amplitude at some pixels within `reach_px` of the centre, in units of the
/// image's peak amplitude.
double amplitude_error(const Config& config, int reach_px) {
  const Image<float> image = image_of(config);
  const double peak = std::sqrt(*std::max_element(image.pixels.begin(), image.pixels.end()));
  double error = 0.0;
  for (int k = 0; k < 30; ++k) {
    const int x = 127 + (k * 37) % (2 * reach_px + 1) - reach_px;
    const int y = 128 + (k * 53) % (2 * reach_px + 1) - reach_px;
    const double want = std::sqrt(brute_force(config, {double(x), double(y)}));
    error = std::max(error, std::abs(std::sqrt(double(image.at(x, y))) - want) / peak);
  }
  std::printf("  amplitude error %.5f of the peak\n", error);
  return error;
}

TEST(ArrayModel, ASquareLensletAloneGivesSincSquared) {
  const Config config = array_of(R"({"columns": 1, "rows": 1})");
  const Image<float> image = image_of(config);
  const double lambda_d_px = 632e-3 * 5.2e3 / 150.0 / 5.3;
  const auto sinc = [](double u) { return u == 0.0 ? 1.0 : std::sin(kPi * u) / (kPi * u); };
  const double peak = std::pow(150.0 * 150.0 / unit(config), 2);
  for (int y = 90; y < 168; ++y) {
    for (int x = 90; x < 166; ++x) {
      const double want =
          std::pow(sinc((x - 127.3) / lambda_d_px) * sinc((y - 128.6) / lambda_d_px), 2);
      ASSERT_NEAR(image.at(x, y) / peak, want, 2e-5) << x << " " << y;
    }
  }
}

TEST(ArrayModel, ARoundLensletAloneGivesTheAiryPattern) {
  const Config config = array_of(R"({"columns": 1, "rows": 1, "shape": "circle"})");
  const Image<float> image = image_of(config);
  const double lambda_d_px = 632e-3 * 5.2e3 / 150.0 / 5.3;
  for (int y = 90; y < 168; ++y) {
    for (int x = 90; x < 166; ++x) {
      const double v = kPi * std::hypot(x - 127.3, y - 128.6) / lambda_d_px;
      const double want = std::pow(2.0 * std::cyl_bessel_j(1.0, v) / v, 2);
      ASSERT_NEAR(image.at(x, y) * kVortexPeak * kVortexPeak, want, 1e-3) << x << " " << y;
    }
  }
}

TEST(ArrayModel, ARoundVortexIsAsBrightAsTheUnitSays) {
  const Config config = array_of(R"({"columns": 1, "rows": 1, "shape": "circle"})", 1);
  const Image<float> image = image_of(config);
  EXPECT_NEAR(*std::max_element(image.pixels.begin(), image.pixels.end()), 1.0, 0.03);
}

TEST(ArrayModel, AgreesWithABruteForceSumUnderAberration) {
  const std::string aberration =
      R"(, "aberration": [{"j": 3, "waves": 0.3}, {"j": 4, "waves": 0.4}, {"j": 7, "waves": -0.2}])";
  // Reach: the light of all lenslets, so that nothing is cut off.
  const std::string three = R"("columns": 3, "rows": 3, "reach_pitches": 4, "pupil_mm": 0.6)";
  const auto error = [&](const std::string& array, int charge, const std::string& more = "") {
    return amplitude_error(array_of("{" + three + array + "}", charge, aberration + more), 40);
  };
  EXPECT_LT(error("", 0), 2e-3);
  EXPECT_LT(error("", 1), 3e-3);
  EXPECT_LT(error(R"(, "lattice": "hexagonal", "shape": "circle")", 1), 6e-3);
  EXPECT_LT(error(R"(, "lattice": "hexagonal")", 0), 3e-3);
  EXPECT_LT(error(R"(, "lattice": "hexagonal")", 1, R"(, "camera": {"rotation_deg": 13})"), 8e-3);
  EXPECT_LT(error(R"(, "plate": {"levels": 16, "depth": 1.05, "shift_um": [3, -2]})", 1,
                  R"(, "camera": {"rotation_deg": 13, "mirror": "y"})"),
            8e-3);
}

/// What the sensor's model of these lenslets leaves of the middle spots, relative to their pixels.
/// The twin computes the light of a lenslet within 4 pitches, the model that within 4.5.
double residual(const Config& config, LensletShape shape) {
  const double px_um = config.optics.camera_pitch_um;
  SensorConfig sensor;
  sensor.charge = config.sensor.charge;
  sensor.grooves = {0.0, 0.0};
  sensor.grid = config.array.lattice;
  sensor.subapertures_across = 7;
  sensor.pupil_diameter_px = pupil_um(config.array) / px_um;
  sensor.lenslets = {shape,
                     config.array.pitch_um / px_um,
                     0.0,
                     {},
                     config.optics.wavelength_nm * config.optics.focal_length_mm / (px_um * px_um),
                     {}};
  for (const Vec2 centre : lenslet_centres(config.array)) {
    sensor.lenslets.centres_px.push_back((1.0 / px_um) * centre);
  }
  OpticsConfig optics;
  optics.registered = PxPerCycle(sensor.lenslets.px_per_cycle);
  optics.centre_px = config.truth.geometry.centre_px;
  auto renderer =
      SpotRenderer::make(sensor, {16, 16, px_um}, optics, 256, 256, {1, 2, 4}, {}).value();
  const Image<float> image = image_of(config);
  double left = 0.0, all = 0.0;
  for (const RenderedSpot& spot : renderer.render(std::vector<double>(3, 0.0))) {
    if (norm(spot.place_px - *optics.centre_px) > 1.2 * sensor.lenslets.width_px) continue;
    Eigen::VectorXf seen(spot.light.size());
    each_pixel(spot.window, [&](Eigen::Index cell, int x, int y) { seen(cell) = image.at(x, y); });
    const float level = seen.dot(spot.light) / spot.light.squaredNorm();
    left += double((seen - level * spot.light).squaredNorm());
    all += double(seen.squaredNorm());
  }
  return std::sqrt(left / all);
}

TEST(ArrayModel, TheSensorsModelOfAnArrayThatIsNotDescribedFurtherIsThis) {
  for (const std::string lattice : {"square", "hexagonal"}) {
    const auto left = [&](int charge, std::optional<LensletShape> shape) {
      const Config config = array_of(
          R"({"columns": 7, "rows": 7, "reach_pitches": 4, "lattice": ")" + lattice + "\"}",
          charge);
      return residual(config, shape.value_or(filling_shape(config.array.lattice)));
    };
    const double bright = left(0, {}), vortex = left(1, {}),
                 squares = left(0, LensletShape::square);
    std::printf("  %s: residual of bright spots %.4f, of vortices %.4f; of squares %.4f\n",
                lattice.c_str(), bright, vortex, squares);
    EXPECT_LT(bright, 0.01);
    EXPECT_LT(vortex, 0.01);
    EXPECT_TRUE(lattice == "square" || squares > 0.1);
  }
}

TEST(ArrayModel, WhatLiesBeyondTheReachIsSmall) {
  // Crosstalk that the default reach leaves out, as a part of the peak's amplitude.
  const Config near = array_of(R"({"columns": 7, "rows": 7, "pupil_mm": 1.05})", 1);
  const Config far =
      array_of(R"({"columns": 7, "rows": 7, "pupil_mm": 1.05, "reach_pitches": 4})", 1);
  const Image<float> a = image_of(near), b = image_of(far);
  double error = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    error = std::max(error, double(std::abs(std::sqrt(a.pixels[i]) - std::sqrt(b.pixels[i]))));
  }
  std::printf("  amplitude beyond 1.5 pitches: %.3f\n", error);
  EXPECT_LT(error, 0.15);
}

TEST(ArrayModel, ATiltMovesTheSpotsToWhereTheTruthSays) {
  Config config = array_of(R"({"columns": 5, "rows": 5, "shape": "circle"})", 0,
                           R"(, "aberration": [{"j": 2, "waves": 0.7}, {"j": 1, "waves": -0.4}],
                               "camera": {"rotation_deg": 90})");
  ArrayModel model(config);
  model.set_window({0, 0, 256, 256}, config.truth.geometry);
  const Image<float> image = model.intensity(kNoGrey);
  const std::vector<Vec2> spots = model.true_spots_px(config.truth);
  ASSERT_EQ(spots.size(), 25U);
  for (const Vec2 spot : spots) {
    Vec2 centre;
    double sum = 0.0;
    for (int y = int(spot.y) - 3; y <= int(spot.y) + 4; ++y) {
      for (int x = int(spot.x) - 3; x <= int(spot.x) + 4; ++x) {
        const double light = std::pow(double(image.at(x, y)), 2);
        centre = centre + light * Vec2{double(x), double(y)};
        sum += light;
      }
    }
    EXPECT_LT(norm((1.0 / sum) * centre - spot), 0.3);
  }
}

TEST(ArrayModel, TheLightOfALensletIsWhatThePhotonsSay) {
  const Config config = array_of(R"({"columns": 1, "rows": 1, "reach_pitches": 4})", 1);
  const Image<float> image = image_of(config);
  const double sum = std::accumulate(image.pixels.begin(), image.pixels.end(), 0.0);
  const ArrayModel model(config);
  EXPECT_NEAR(sum / model.photons_per_peak_photon(config.truth.geometry), 1.0, 0.04);
}

TEST(ArrayModel, TheBeamLightsSomeLensletsOnly) {
  const Config config = array_of(R"({"columns": 7, "rows": 7, "beam_diameter_mm": 0.5})");
  const Image<float> image = image_of(config);
  EXPECT_GT(image.at(127, 129), 5.0F);
  EXPECT_LT(image.at(127 + 85, 129), 0.05F);
  EXPECT_EQ(ArrayModel(config).true_spots_px(config.truth).size(), 9U);
}

TEST(ArrayModel, TurbulenceMovesTheSpots) {
  const Config config = array_of(R"({"columns": 5, "rows": 5})");
  ArrayModel model(config);
  model.set_window({0, 0, 256, 256}, config.truth.geometry);
  const Image<float> still = model.intensity(kNoGrey);
  const Turbulence air({.rms_waves = 0.3});
  model.set_turbulence(&air, 1'000'000'000);
  EXPECT_NE(model.intensity(kNoGrey).pixels, still.pixels);
  model.set_turbulence(nullptr, 0);
  EXPECT_EQ(model.intensity(kNoGrey).pixels, still.pixels);
}

TEST(ArrayModel, AShadeDarkensTheLensletsBehindIt) {
  const Config config = array_of(R"({"columns": 5, "rows": 5})");
  ArrayModel model(config);
  model.set_window({0, 0, 256, 256}, config.truth.geometry);
  const float before = model.intensity(kNoGrey).at(127, 129);
  model.set_light({{}, {{{127.3, 128.6}, 20.0, 0.25}}});
  EXPECT_NEAR(model.intensity(kNoGrey).at(127, 129) / before, 0.25, 0.06);
}

TEST(ArrayConfig, RefusesWhatCannotBeSimulated) {
  const auto fault = [](const std::string& array, const std::string& more = "") {
    const auto config = parse_config(R"({"modulator": "fixed", "optics": {"focal_length_mm": 5.2,
        "camera_pitch_um": 5.3)" + more +
                                     R"(}, "array": )" + array + "}");
    return config ? std::string("none") : config.error().field;
  };
  EXPECT_EQ(fault("{}"), "none");
  EXPECT_EQ(fault(R"({"pitch_um": 3000})"), "array.reach_pitches");
  EXPECT_EQ(fault(R"({"columns": 0})"), "array.columns");
  EXPECT_EQ(fault(R"({"lattice": "round"})"), "array.lattice");
  EXPECT_EQ(fault(R"({"lattice": "hexagonal"})"), "none");
  EXPECT_EQ(fault(R"({"lattice": "hexagonal", "shape": "square"})"), "array.shape");
  EXPECT_EQ(fault(R"({"shape": "hexagon"})"), "array.shape");
  EXPECT_EQ(fault(R"({"plate": {"steps": 8}})"), "array.plate.steps");
  EXPECT_EQ(fault(R"({"pitch_um": 400})"), "optics.focal_length_mm");
}

TEST(ArrayLayout, AHexagonalLatticeHasItsMiddleLensletAtTheCentre) {
  const ArrayConfig array{.lattice = Grid::hexagonal, .columns = 3, .rows = 3};
  const std::vector<Vec2> centres = lenslet_centres(array);
  ASSERT_EQ(centres.size(), 9U);
  EXPECT_EQ(centres[4], (Vec2{0.0, 0.0}));
  for (const std::size_t neighbour : {0U, 1U, 3U, 5U, 6U, 7U}) {
    EXPECT_NEAR(norm(centres[neighbour]), 150.0, 1e-9) << neighbour;
  }
  EXPECT_NEAR(pupil_um(array), 3 * 150.0 * std::sqrt(0.75), 1e-9);
}

TEST(Plate, HasStepsADepthAndAnAxis) {
  const Vec2 below{0.0, 10.0};  // a quarter of a turn, as y points down
  EXPECT_NEAR(plate_radians({}, 1, below), kPi / 2, 1e-12);
  EXPECT_NEAR(plate_radians({}, -2, below), -kPi, 1e-12);
  EXPECT_NEAR(plate_radians({.depth = 1.05}, 1, {1.0, -1e-9}), 1.05 * 2.0 * kPi, 1e-6);
  EXPECT_NEAR(plate_radians({.shift_um = {3.0, 10.0}}, 1, {0.0, 10.0}), kPi, 1e-12);
  const PlateConfig steps{.levels = 8};
  EXPECT_NEAR(plate_radians(steps, 1, {1.0, 0.1}), kPi / 8, 1e-12);
  EXPECT_NEAR(plate_radians(steps, 1, {1.0, 0.9}), kPi / 8, 1e-12);
  EXPECT_NEAR(plate_radians(steps, 1, {1.0, 1.1}), 3.0 * kPi / 8, 1e-12);
}

/// In processor time, which a busy machine hardly changes.
TEST(ArrayModel, ANewWavefrontTakesLessThanASecond) {
  for (const int across : {9, 47}) {
    const Config config = array_of("{\"columns\": " + std::to_string(across) +
                                       ", \"rows\": " + std::to_string(across == 9 ? 9 : 35) + "}",
                                   1);
    ArrayModel model(config);
    model.set_window({-600, -600, 1280, 1280}, config.truth.geometry);
    const auto took_ms = [&] {
      const std::clock_t start = std::clock();
      model.intensity(kNoGrey);
      return 1e3 * double(std::clock() - start) / CLOCKS_PER_SEC;
    };
    const double first = took_ms();
    model.set_light({{{4, 0.3}}, {}});
    const double next = took_ms();
    std::printf("  %d lenslets: %.1f ms at first, %.2f ms for a new wavefront\n",
                across * (across == 9 ? 9 : 35), first, next);
    EXPECT_LT(next, 1000.0);
  }
}

}  // namespace
}  // namespace ovws::twin
