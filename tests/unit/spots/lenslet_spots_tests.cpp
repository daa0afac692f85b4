/// Rendered spots of a lenslet array against Fresnel's integral.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/spot_renderer.hpp"

namespace ovws {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kWidth = 192, kHeight = 180;

/// 5 x 5 lenslets of 30 pixels, lambda/pitch 4 pixels, in an image of 192 x 180 pixels.
struct ArrayCase {
  SensorConfig sensor;
  SlmGeometry slm{16, 16, 5.3};
  OpticsConfig optics;
  std::vector<int> modes_j{1, 2, 3, 4, 5, 8, 12};
  std::vector<double> waves{0.3, -0.2, 0.2, 0.25, -0.15, 0.1, 0.05};

  /// `seen`: how the camera sees the array, of scale 1.
  explicit ArrayCase(int charge, SpiralPlate plate, LensletShape shape, PxPerCycle seen = 1.0) {
    sensor.charge = charge;
    sensor.grooves = {0.0, 0.0};
    sensor.pupil_diameter_px = 150.0;
    sensor.subapertures_across = 5;
    sensor.lenslets = {shape, 30.0, 0.0, plate, 120.0, {}};
    const double row_px = shape == LensletShape::hexagon ? 30.0 * std::sqrt(0.75) : 30.0;
    for (int k = 0; k < 25; ++k) {
      const double aside = shape == LensletShape::hexagon && k / 5 % 2 != 0 ? 15.0 : 0.0;
      sensor.lenslets.centres_px.push_back(
          {30.0 * (k % 5 - 2) + aside + 0.2, row_px * (k / 5 - 2) - 0.4});
    }
    optics.registered = seen / (1.0 / 120.0);
    optics.centre_px = Vec2{95.3, 90.1};
  }

  double phase_waves(Vec2 at) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      sum += waves[k] * zernike(modes_j[k], (2.0 / sensor.pupil_diameter_px) * at);
    }
    return sum;
  }
  double plate_waves(Vec2 from_centre) const {
    const SpiralPlate& plate = sensor.lenslets.plate;
    const Vec2 off = from_centre - plate.shift_px;
    double turns = std::atan2(off.y, off.x) / (2.0 * kPi);
    if (turns < 0.0) turns += 1.0;
    if (plate.levels > 0) turns = std::floor(turns * plate.levels) / plate.levels;
    return sensor.charge * plate.depth * turns;
  }
  bool covers(Vec2 from_centre) const {
    const double x = std::abs(from_centre.x), y = std::abs(from_centre.y);
    if (sensor.lenslets.shape == LensletShape::circle) return norm(from_centre) <= 15.0;
    if (sensor.lenslets.shape == LensletShape::square) return x <= 15.0 && y <= 15.0;
    return x <= 15.0 && 0.5 * x + std::sqrt(0.75) * y <= 15.0;
  }
  /// Light of every camera pixel, in the camera's rows and columns. A camera that sees the array
  /// turned by 90 degrees has the array's rows as its columns.
  Eigen::MatrixXd light() const {
    const PxPerCycle& seen = *optics.registered;
    const Vec2 x = seen.back({1.0, 0.0}), y = seen.back({0.0, 1.0});
    const auto places = [](int size, double middle_px, double sign) {
      const Eigen::ArrayXd pixels = Eigen::ArrayXd::LinSpaced(size, 0.0, size - 1.0);
      return Eigen::ArrayXd(sign * (pixels - middle_px));
    };
    const Eigen::ArrayXd columns = places(kWidth, optics.centre_px->x, x.x + x.y),
                         rows = places(kHeight, optics.centre_px->y, y.x + y.y);
    return std::abs(x.x) > 0.5 ? light_at(columns, rows)
                               : Eigen::MatrixXd(light_at(rows, columns).transpose());
  }
  /// Light at these places along the array's axes: each lenslet is a lens of its own, and Fresnel's
  /// integral takes its light to the camera. Of the kernel exp(i pi |x - r|^2 / lambda f), |x|^2
  /// only turns the whole field, |r|^2 belongs to the lenslet, and x . r is a product of rows and
  /// columns. lambda f = px_per_cycle in square pixels.
  Eigen::MatrixXd light_at(const Eigen::ArrayXd& columns, const Eigen::ArrayXd& rows) const {
    constexpr int kSamples = 144;
    const double lambda_f = sensor.lenslets.px_per_cycle;
    const auto sample = [](int k) { return 36.0 * ((k + 0.5) / kSamples - 0.5); };
    const auto kernel = [&](double centre, const Eigen::ArrayXd& places) -> Eigen::MatrixXcd {
      return Eigen::MatrixXcd::NullaryExpr(places.size(), kSamples, [&](auto pixel, auto k) {
        return std::polar(1.0, -2.0 * kPi * places(pixel) * (centre + sample(int(k))) / lambda_f);
      });
    };
    Eigen::MatrixXcd far = Eigen::MatrixXcd::Zero(rows.size(), columns.size()),
                     near(kSamples, kSamples);
    for (const Vec2 centre : sensor.lenslets.centres_px) {
      for (int row = 0; row < kSamples; ++row) {
        for (int column = 0; column < kSamples; ++column) {
          const Vec2 off{sample(column), sample(row)}, r = centre + off;
          const double lens = -std::pow(norm(off), 2) / (2.0 * lambda_f);
          const double waves_here =
              phase_waves(r) + plate_waves(off) + lens + std::pow(norm(r), 2) / (2.0 * lambda_f);
          near(row, column) = covers(off) ? std::polar(1.0, 2.0 * kPi * waves_here) : 0.0;
        }
      }
      far += kernel(centre.y, rows) * near * kernel(centre.x, columns).transpose();
    }
    return far.cwiseAbs2();
  }
  SpotRenderer renderer() const {
    return SpotRenderer::make(sensor, slm, optics, kWidth, kHeight, modes_j, {}).value();
  }
};

/// Largest and RMS difference of the middle spot's pixels from Fresnel's integral, part of the
/// peak.
struct Difference {
  double most = 0.0, rms = 0.0;
};
Difference difference_of(const ArrayCase& array) {
  SpotRenderer renderer = array.renderer();
  const RenderedSpot spot = renderer.render(array.waves)[12];
  EXPECT_TRUE(is_inside(spot) && spot.window.bin == 1);
  double product = 0.0, squares = 0.0, peak = 0.0;
  std::vector<std::pair<double, double>> pixels;  // expected, rendered
  const Eigen::MatrixXd light = array.light();
  each_pixel(spot.window, [&](Eigen::Index cell, int x, int y) {
    pixels.emplace_back(light(y, x), double(spot.light(cell)));
    product += pixels.back().first * pixels.back().second;
    squares += pixels.back().second * pixels.back().second;
    peak = std::max(peak, pixels.back().first);
  });
  Difference difference;
  for (const auto& [expected, rendered] : pixels) {
    const double off = (rendered * product / squares - expected) / peak;
    difference.most = std::max(difference.most, std::abs(off));
    difference.rms += off * off / double(pixels.size());
  }
  difference.rms = std::sqrt(difference.rms);
  return difference;
}

TEST(LensletSpots, AreThoseOfFresnelsIntegral) {
  const SpiralPlate made{16, 1.05, {0.6, 0.0}};
  for (const ArrayCase& array :
       {ArrayCase(0, {}, LensletShape::square), ArrayCase(0, {}, LensletShape::circle)}) {
    const Difference difference = difference_of(array);
    EXPECT_LT(difference.most, 0.01);
    EXPECT_LT(difference.rms, 0.0015);
  }
  for (const ArrayCase& array :
       {ArrayCase(1, {}, LensletShape::circle), ArrayCase(1, made, LensletShape::circle),
        ArrayCase(1, made, LensletShape::square)}) {
    const Difference difference = difference_of(array);
    EXPECT_LT(difference.most, 0.035);
    EXPECT_LT(difference.rms, 0.008);
  }
}

/// How a camera may see an array: mirrors and quarter turns.
const std::vector<PxPerCycle> kSeen{{1, 0, 0, 1}, {-1, 0, 0, 1},  {1, 0, 0, -1}, {-1, 0, 0, -1},
                                    {0, 1, 1, 0}, {0, -1, -1, 0}, {0, -1, 1, 0}, {0, 1, -1, 0}};

TEST(LensletSpots, AreSeenInTheCamerasDirection) {
  const SpiralPlate made{16, 1.05, {0.6, 0.0}};
  for (const PxPerCycle& seen : kSeen) {
    const Difference bright = difference_of(ArrayCase(0, {}, LensletShape::hexagon, seen));
    std::printf("  [%g %g %g %g]: bright hexagons %.4f (RMS %.4f)", seen.xx, seen.xy, seen.yx,
                seen.yy, bright.most, bright.rms);
    EXPECT_LT(bright.most, 0.01);
    EXPECT_LT(bright.rms, 0.0015);
    const Difference vortex = difference_of(ArrayCase(1, made, LensletShape::square, seen));
    std::printf(", vortices %.4f (RMS %.4f)\n", vortex.most, vortex.rms);
    EXPECT_LT(vortex.most, 0.035);
    EXPECT_LT(vortex.rms, 0.008);
  }
}

/// Largest error of a derivative of three spots, relative to that of a tilt; of the light of other
/// lenslets, only that of the nearest ones changes in the rendered derivatives.
float derivative_error(const ArrayCase& array) {
  SpotRenderer renderer = array.renderer();
  const std::vector<RenderedSpot> spots = renderer.render(array.waves);
  float most = 0.0F, tilt = 0.0F;
  for (const std::size_t mode : {0U, 3U, 4U}) {
    constexpr double kStep = 1e-3;
    std::vector<double> more = array.waves, less = array.waves;
    more[mode] += kStep;
    less[mode] -= kStep;
    const auto plus = renderer.light_in(spots, more, {}),
               minus = renderer.light_in(spots, less, {});
    for (const std::size_t i : {6U, 12U, 18U}) {
      const Eigen::VectorXf numeric = (plus[i] - minus[i]) / float(2.0 * kStep);
      const Eigen::VectorXf analytic = spots[i].per_wave.col(Eigen::Index(mode));
      if (mode == 0U) tilt = std::max(tilt, numeric.norm());
      most = std::max(most, (numeric - analytic).norm() / tilt);
    }
  }
  return most;
}

TEST(LensletSpots, DerivativesAreThoseOfTheRendering) {
  EXPECT_LT(derivative_error(ArrayCase(0, {}, LensletShape::circle)), 0.2F);
  EXPECT_LT(derivative_error(ArrayCase(1, {16, 1.05, {0.6, 0.0}}, LensletShape::square)), 0.5F);
}

}  // namespace
}  // namespace ovws
