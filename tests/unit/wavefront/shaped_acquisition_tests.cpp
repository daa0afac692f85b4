/// Acquisition of split spots against the model of the whole sensor.
#include "core/wavefront/shaped_acquisition.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "core/optics/random_modes.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr int kImagePx = 512;
constexpr double kPeakDn = 4000.0;

std::vector<int> modes_18() {
  std::vector<int> modes(18);
  std::iota(modes.begin(), modes.end(), 1);
  return modes;
}

SensorConfig sensor_of(int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  return sensor;
}

std::vector<Mode> random_modes(std::uint64_t seed, double rms_waves) {
  std::mt19937_64 random(seed);
  return ovws::random_modes(random, 18, rms_waves);
}

Eigen::VectorXd waves_of(const std::vector<Mode>& modes) {
  Eigen::VectorXd waves = Eigen::VectorXd::Zero(18);
  for (const Mode& mode : modes) waves(mode.j - 1) = mode.waves;
  return waves;
}

/// The default bench with one charge; references are the model's spots.
struct Bench {
  explicit Bench(int charge, TrackerKind kind = TrackerKind::matched)
      : sensor(sensor_of(charge)),
        model(SensorModel::make(sensor, {}, {}, kImagePx, kImagePx).value()),
        spots{charge, model.lambda_d_px()},
        tracker(make_tracker({kind}, spots).value()),
        slopes(slope_matrix(model.lattice(), sensor, modes_18(), slope_model(charge, {kind}),
                            model.px_per_cycle())),
        acquisition(model.lattice(), sensor, spots, model.px_per_cycle(), modes_18(), slopes,
                    model.spots_px(), kImagePx, kImagePx) {}

  std::vector<Vec2> places(const std::vector<Mode>& modes) const {
    const Eigen::VectorXd moved = slopes * waves_of(modes);
    std::vector<Vec2> at = model.spots_px();
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = at[i] + Vec2{moved(Eigen::Index(2 * i)), moved(Eigen::Index(2 * i + 1))};
    }
    return at;
  }

  Image<std::uint16_t> picture(const std::vector<Mode>& modes, double noise_dn) {
    Image<float> intensity = model.intensity(modes).value();
    scale(intensity, kPeakDn / model.peak_of_spots(intensity, modes));
    Image<std::uint16_t> dn(kImagePx, kImagePx);
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(5.0 * noise_dn, noise_dn);
    for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
      const double value = double(intensity.pixels[k]) + (noise_dn > 0.0 ? noise(random) : 0.0);
      dn.pixels[k] = std::uint16_t(std::clamp(std::lround(value), 0L, 65535L));
    }
    return dn;
  }

  std::vector<SpotFix> acquire(const Image<std::uint16_t>& dn) {
    std::vector<SpotFix> fixes(model.spots_px().size());
    TrackScratch scratch = tracker->make_scratch();
    const int found =
        acquisition.acquire(view_of(dn, PixelFormat::mono16), *tracker, scratch, fixes);
    EXPECT_EQ(found, std::count_if(fixes.begin(), fixes.end(), [](auto& f) { return f.found(); }));
    return fixes;
  }

  SensorConfig sensor;
  SensorModel model;
  SpotModel spots;
  std::unique_ptr<const SpotTracker> tracker;
  Eigen::MatrixXd slopes;
  ShapedAcquisition acquisition;
};

struct Counts {
  int refused = 0, wrong = 0;
};
Counts count(const std::vector<SpotFix>& fixes, const std::vector<Vec2>& at, double gross_px) {
  Counts counts;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!fixes[i].found()) {
      ++counts.refused;
    } else if (norm(Vec2{fixes[i].x, fixes[i].y} - at[i]) > gross_px) {
      ++counts.wrong;
    }
  }
  return counts;
}

class Shaped : public testing::TestWithParam<int> {};

/// Intensity of the middle subaperture, by a direct Fourier sum, for modes without a slope there.
Eigen::MatrixXd direct_light(const SensorConfig& sensor, double radius_px,
                             const std::vector<Mode>& modes, const PxPerCycle& map, int half) {
  const Eigen::Matrix2d of_slope{{map.xx, map.xy}, {map.yx, map.yy}};
  const Eigen::Matrix2d to_slope = of_slope.inverse();
  Eigen::MatrixXd intensity(2 * half + 1, 2 * half + 1);
  for (int row = -half; row <= half; ++row) {
    for (int column = -half; column <= half; ++column) {
      const Eigen::Vector2d slope = to_slope * Eigen::Vector2d(column, row);
      std::complex<double> sum;
      for (double y = 0.5 - std::ceil(radius_px); y < radius_px; y += 1.0) {
        for (double x = 0.5 - std::ceil(radius_px); x < radius_px; x += 1.0) {
          if (std::hypot(x, y) > radius_px) continue;
          double cycles = sensor.charge * std::atan2(y, x) / (2.0 * std::numbers::pi);
          for (const Mode& mode : modes) {
            cycles += mode.waves * zernike(mode.j, (2.0 / sensor.pupil_diameter_px) * Vec2{x, y});
          }
          sum += std::polar(1.0, 2.0 * std::numbers::pi * (cycles - slope.x() * x - slope.y() * y));
        }
      }
      intensity(row + half, column + half) = std::norm(sum);
    }
  }
  return intensity;
}

TEST_P(Shaped, ATurnedOrMirroredCameraSeesTheSpotTurnedOrMirrored) {
  SensorConfig sensor = sensor_of(GetParam());
  sensor.pupil_diameter_px = 200.0;  // a direct sum of 40 x 40 pixels
  const Lattice lattice = make_lattice(sensor, {}).value();
  const double radius_px = 0.5 * lattice.diameter_px;
  const std::vector<Mode> modes{{3, 2.5}, {4, -1.0}};
  constexpr int kHalf = 16;
  constexpr double kCos = 0.8387, kSin = 0.5446;  // 33 degrees
  for (const PxPerCycle turned :
       {PxPerCycle(1.0), PxPerCycle(0.0, -1.0, 1.0, 0.0), PxPerCycle(-1.0, 0.0, 0.0, 1.0),
        PxPerCycle(-kCos, -kSin, -kSin, kCos)}) {
    const PxPerCycle map = turned / (1.0 / (8.0 * radius_px));  // lambda/d is 4 bins
    const SpotOptics optics(lattice, sensor, modes_18(), map, kHalf);
    const Eigen::MatrixXd own = optics.intensity(9, waves_of(modes), {}).cast<double>();
    Eigen::MatrixXd direct = direct_light(sensor, radius_px, modes, map, kHalf);
    direct *= own.sum() / direct.sum();
    EXPECT_LT((own - direct).cwiseAbs().maxCoeff(), 0.05 * own.maxCoeff()) << turned.xy;
  }
}

TEST_P(Shaped, SpotIsThatOfTheWholeSensorsModelWithTheOthersDark) {
  const SensorConfig sensor = sensor_of(GetParam());
  SensorField field = SensorField::make(sensor, {}, {}, kImagePx, kImagePx).value();
  const Lattice lattice = make_lattice(sensor, {}).value();
  const double px_per_cycle = camera_px_per_cycle({}, {});
  const SpotOptics optics(lattice, sensor, modes_18(), px_per_cycle, 38);
  const std::vector<Mode> modes = random_modes(3, 0.5);
  const std::vector<Vec2> flat = model_spots_px(lattice, sensor, {}, {}, kImagePx, kImagePx);
  field.set_outside(false);
  for (const int spot : {0, 9, 18}) {
    std::vector<double> amplitudes(lattice.subapertures.size(), 0.0);
    amplitudes[std::size_t(spot)] = 1.0;
    field.propagate(modes, {.amplitudes = amplitudes});
    const Eigen::VectorXd tilts = optics.local_modes(spot) * waves_of(modes);
    const Vec2 at = flat[std::size_t(spot)] + optics.cells_per_tilt() * Vec2{tilts(1), tilts(0)};
    const int x = int(std::lround(at.x)), y = int(std::lround(at.y));
    const auto own = optics.intensity(spot, waves_of(modes), {at.x - x, at.y - y});
    Eigen::MatrixXf seen(own.rows(), own.cols());
    for (Eigen::Index r = 0; r < own.rows(); ++r) {
      for (Eigen::Index c = 0; c < own.cols(); ++c) {
        seen(r, c) = std::norm(field.far().at(x + int(c) - 38, y + int(r) - 38));
      }
    }
    seen *= own.sum() / seen.sum();
    EXPECT_LT((own - seen).cwiseAbs().maxCoeff(), 0.05F * own.maxCoeff()) << spot;
  }
}

TEST_P(Shaped, DerivativesAreThoseOfTheLight) {
  const SensorConfig sensor = sensor_of(GetParam());
  const Lattice lattice = make_lattice(sensor, {}).value();
  const SpotOptics optics(lattice, sensor, modes_18(), camera_px_per_cycle({}, {}) / 2.0, 19);
  const Eigen::VectorXd waves = waves_of(random_modes(4, 0.4));
  const auto derived = optics.derive(2, waves, {0.2, -0.3});
  EXPECT_LT((derived.intensity - optics.intensity(2, waves, {0.2, -0.3})).cwiseAbs().maxCoeff(),
            1e-5F);
  constexpr double kStep = 0.01;
  for (int j = 1; j <= 18; ++j) {
    Eigen::VectorXd more = waves, less = waves;
    more(j - 1) += kStep;
    less(j - 1) -= kStep;
    const Eigen::VectorXd local = optics.local_modes(2) * (more - less) / (2.0 * kStep);
    Eigen::MatrixXf expected = Eigen::MatrixXf::Zero(39, 39);
    // The computed spot follows the mean slope, so that the tilts only move it.
    for (int k = 2; k < SpotOptics::kLocal; ++k) expected += float(local(k)) * derived.per_wave[k];
    const Eigen::MatrixXf seen =
        (optics.intensity(2, more, {0.2, -0.3}) - optics.intensity(2, less, {0.2, -0.3})) /
        float(2.0 * kStep);
    const float off = (seen - expected).cwiseAbs().maxCoeff();
    EXPECT_LT(off, 0.05F * seen.cwiseAbs().maxCoeff() + 0.05F) << j;
  }
  const double step = 0.1;
  const Eigen::MatrixXf moved = (optics.intensity(2, waves, {0.2 + step, -0.3}) -
                                 optics.intensity(2, waves, {0.2 - step, -0.3})) /
                                float(2.0 * step / optics.cells_per_tilt());
  EXPECT_LT((moved - derived.per_wave[1]).cwiseAbs().maxCoeff(),
            0.02F * moved.cwiseAbs().maxCoeff());
}

TEST_P(Shaped, SpotsOfHalfAWaveAreFoundInOneImage) {
  Bench bench(GetParam());
  Counts all;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    for (const double noise_dn : {0.0, 400.0, 1300.0}) {
      const auto modes = random_modes(seed, 0.5);
      const Counts counts = count(bench.acquire(bench.picture(modes, noise_dn)),
                                  bench.places(modes), 0.5 * bench.spots.lambda_d_px);
      all.refused += counts.refused;
      all.wrong += counts.wrong;
    }
  }
  EXPECT_EQ(all.wrong, 0);
  EXPECT_LE(all.refused, 7);  // 3 % of 228; a tracker alone rejects a third
}

INSTANTIATE_TEST_SUITE_P(OfCharge, Shaped, testing::Values(0, 1, -1, 2));

TEST(ShapedAcquisition, WhereASpotIsMissingNoneIsFound) {
  Bench bench(1);
  const auto modes = random_modes(2, 0.4);
  auto dn = bench.picture(modes, 100.0);
  const std::vector<Vec2> at = bench.places(modes);
  const int half = int(1.8 * bench.spots.lambda_d_px);
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      dn.at(int(at[0].x) + x, int(at[0].y) + y) = std::uint16_t(450 + (x * 31 + y * 17) % 100);
    }
  }
  const auto fixes = bench.acquire(dn);
  EXPECT_FALSE(fixes[0].found());
  const Counts counts = count(fixes, at, 0.5 * bench.spots.lambda_d_px);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_LE(counts.refused, 2);
  // Its predicted position, where it is searched from now on: noise must not have moved that.
  const ShapedSpot& dark = bench.acquisition.shapes().at(0);
  EXPECT_FALSE(dark.found);
  EXPECT_LT(norm(dark.at_px - at[0]), 0.25 * bench.spots.lambda_d_px);
}

TEST(ShapedAcquisition, AnImageOfAnotherSizeHasNothingWhateverWasBefore) {
  Bench bench(1);
  const auto dn = bench.picture(random_modes(2, 0.5), 0.0);
  EXPECT_LE(count(bench.acquire(dn), bench.places({}), 1e9).refused, 1);
  EXPECT_FALSE(bench.acquisition.shapes().empty());
  Image<std::uint16_t> larger(600, 560);
  for (int y = 0; y < kImagePx; ++y) std::copy_n(dn.row(y), kImagePx, larger.row(y));
  for (const SpotFix& fix : bench.acquire(larger)) EXPECT_FALSE(fix.found());
  EXPECT_TRUE(bench.acquisition.shapes().empty());
}

TEST(ShapedAcquisition, NoiseStripesAndATurnedImageHaveNoSpots) {
  Bench bench(1);
  auto turned = bench.picture(random_modes(1, 0.3), 100.0);
  for (int y = 0; y < kImagePx; ++y) {
    for (int x = 0; x < y; ++x) std::swap(turned.at(x, y), turned.at(y, x));
  }
  Image<std::uint16_t> noise(kImagePx, kImagePx), stripes(kImagePx, kImagePx);
  std::mt19937_64 random(1);
  for (int y = 0; y < kImagePx; ++y) {
    for (int x = 0; x < kImagePx; ++x) {
      noise.at(x, y) = std::uint16_t(random() % 4000);
      stripes.at(x, y) = std::uint16_t((x + y) / 25 % 2 == 0 ? 4000 : 100);
    }
  }
  Image<std::uint16_t> black(kImagePx, kImagePx, 0), white(kImagePx, kImagePx, 65535);
  for (const Image<std::uint16_t>* dn : {&turned, &noise, &stripes, &black, &white}) {
    for (const SpotFix& fix : bench.acquire(*dn)) EXPECT_FALSE(fix.found());
  }
}

}  // namespace
}  // namespace ovws
