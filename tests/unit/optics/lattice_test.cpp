/// Geometry and lattice: the paper's bench in numbers, counts, order and limits.
#include "core/optics/lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace ovws {
namespace {

Lattice lattice_of(const SensorConfig& sensor) {
  return make_lattice(sensor, SlmGeometry{}).value();
}

std::string field_of_error(const SensorConfig& sensor) {
  const auto lattice = make_lattice(sensor, SlmGeometry{});
  if (lattice) return "no error";
  EXPECT_EQ(lattice.error().code, Errc::invalid);
  EXPECT_FALSE(lattice.error().reason.empty());
  return lattice.error().field;
}

TEST(Geometry, GivesTheScaleOfThePapersBench) {
  // 632e-9 m * 0.2 m / (19e-6 m * 3.45e-6 m).
  EXPECT_NEAR(camera_px_per_cycle({}, {}), 1928.299, 1e-3);
  // lambda f / (153.6 * 19 um), in camera pixels of 3.45 um.
  EXPECT_NEAR(lambda_d_px({}, {}, {}), 12.554, 1e-3);
}

TEST(Geometry, ARegistrationReplacesTheConfiguredScaleAndRotation) {
  OpticsConfig optics;
  optics.registered = PxPerCycle{0.0, 1900.0, 2000.0, 0.0};  // x and y exchanged: a mirror
  EXPECT_NEAR(camera_px_per_cycle(optics, {}), std::sqrt(1900.0 * 2000.0), 1e-9);
  EXPECT_TRUE(px_per_cycle(optics, {}).mirrored());
  EXPECT_FALSE(px_per_cycle({}, {}).mirrored());
  EXPECT_NEAR(px_per_cycle(optics, {}).rotation_deg(), 90.0, 1e-9);
  const Lattice lattice = make_lattice({}, {}).value();
  const auto spots = model_spots_px(lattice, {}, {}, optics, 512, 512);
  const Vec2 base = lattice.subapertures[9].frequency_cpp;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 f = lattice.subapertures[i].frequency_cpp - base;
    EXPECT_NEAR(spots[i].x, 255.5 + 1900.0 * f.y, 1e-9);
    EXPECT_NEAR(spots[i].y, 255.5 + 2000.0 * f.x, 1e-9);
  }
}

/// Fresnel diffraction from a pupil in the plane of the lens: intensity on the axis at F + z.
double on_axis(double defocus_waves, double z_mm, double focal_mm) {
  constexpr double kRadiusMm = 384.0 * 0.019, kWavelengthMm = 632e-6;
  constexpr int kSteps = 2000;
  std::complex<double> sum;
  for (int k = 0; k < kSteps; ++k) {
    const double part = (k + 0.5) / kSteps, r = part * kRadiusMm;
    const double waves = defocus_waves * std::sqrt(3.0) * (2.0 * part * part - 1.0) -
                         r * r / (2.0 * kWavelengthMm * focal_mm) +
                         r * r / (2.0 * kWavelengthMm * (focal_mm + z_mm));
    sum += std::polar(r, 2.0 * std::numbers::pi * waves);
  }
  return std::norm(sum) / ((focal_mm + z_mm) * (focal_mm + z_mm));
}

TEST(Geometry, GivesTheDistanceFromTheFocusThatFresnelDiffractionHas) {
  for (const double waves : {-0.2, 0.2}) {
    double best_mm = 0.0, most = 0.0;  // where the focus is
    for (double z_mm = -1.5; z_mm < 1.5; z_mm += 0.001) {
      const double intensity = on_axis(waves, z_mm, 200.0);
      if (intensity <= most) continue;
      most = intensity;
      best_mm = z_mm;
    }
    EXPECT_NEAR(waves * camera_shift_mm_per_wave({}, {}, 768.0), -best_mm, 0.005);
  }
  OpticsConfig relayed;
  relayed.magnification = 3.0;  // a relay stretches distances along the axis by its square
  EXPECT_NEAR(camera_shift_mm_per_wave(relayed, {}, 768.0),
              9.0 * camera_shift_mm_per_wave({}, {}, 768.0), 1e-9);
}

TEST(Geometry, PutsTheBaseSpotOnTheMiddleOfTheImageUnlessSetOtherwise) {
  OpticsConfig optics;
  EXPECT_EQ(base_spot_px(optics, 512, 301), (Vec2{255.5, 150.0}));
  optics.centre_px = Vec2{12.0, 34.5};
  EXPECT_EQ(base_spot_px(optics, 512, 301), (Vec2{12.0, 34.5}));
}

TEST(Lattice, HasThePapers19HexagonalSubapertures) {
  const Lattice lattice = lattice_of({});
  EXPECT_EQ(lattice.subapertures.size(), 19u);
  EXPECT_DOUBLE_EQ(lattice.diameter_px, 153.6);
}

TEST(Lattice, CountsWholeCirclesOnly) {
  const auto count = [](Grid grid, int across) {
    SensorConfig sensor;
    sensor.grid = grid;
    sensor.subapertures_across = across;
    sensor.spacing = 0.1;
    return lattice_of(sensor).subapertures.size();
  };
  // Hexagonal: points at 0, 1, sqrt 3, 2, sqrt 7, 3, sqrt 12, sqrt 13, 4 pitches are 1, 6, 6, 6,
  // 12, 6, 6, 12, 6.
  EXPECT_EQ(count(Grid::hexagonal, 3), 7u);
  EXPECT_EQ(count(Grid::hexagonal, 7), 37u);
  EXPECT_EQ(count(Grid::hexagonal, 9), 61u);
  // Square: the points of Z^2 within (M-1)/2.
  EXPECT_EQ(count(Grid::square, 3), 5u);
  EXPECT_EQ(count(Grid::square, 5), 13u);
  EXPECT_EQ(count(Grid::square, 6), 21u);
  EXPECT_EQ(count(Grid::square, 7), 29u);
}

TEST(Lattice, NumbersByRowsOfIncreasingYThenX) {
  const auto subapertures = lattice_of({}).subapertures;
  const int rows[] = {3, 4, 5, 4, 3};
  std::size_t i = 0;
  for (int row = 0; row < 5; ++row) {
    for (int col = 0; col < rows[row]; ++col, ++i) {
      const Vec2 centre = subapertures[i].centre_px;
      EXPECT_NEAR(centre.x, (col - 0.5 * (rows[row] - 1)) * 153.6, 1e-9) << i;
      EXPECT_NEAR(centre.y, (row - 2) * 153.6 * std::sqrt(3.0) / 2.0, 1e-9) << i;
    }
  }
  EXPECT_EQ(subapertures[9].centre_px, (Vec2{0.0, 0.0}));
}

TEST(Lattice, IsSymmetricAboutThePupilsCentre) {
  for (const Grid grid : {Grid::hexagonal, Grid::square}) {
    SensorConfig sensor;
    sensor.grid = grid;
    sensor.subapertures_across = 7;
    const auto subapertures = lattice_of(sensor).subapertures;
    for (std::size_t i = 0; i < subapertures.size(); ++i) {
      const Vec2 sum = subapertures[i].centre_px + subapertures.rbegin()[i].centre_px;
      EXPECT_EQ(sum, (Vec2{0.0, 0.0}));
    }
  }
}

TEST(Lattice, GivesEachSubapertureItsGratingAndItsSpot) {
  const SensorConfig sensor;
  const SlmGeometry slm;
  OpticsConfig optics;
  optics.centre_px = Vec2{250.0, 240.0};
  const Lattice lattice = lattice_of(sensor);
  const auto spots = model_spots_px(lattice, sensor, slm, optics, 512, 512);
  ASSERT_EQ(spots.size(), lattice.subapertures.size());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const auto [centre, f, charge] = lattice.subapertures[i];
    EXPECT_EQ(charge, sensor.charge);
    EXPECT_DOUBLE_EQ(f.x, (200.0 + 0.25 * centre.x) / 1280.0);
    EXPECT_DOUBLE_EQ(f.y, (20.0 + 0.25 * centre.y) / 768.0);
    EXPECT_NEAR(spots[i].x, 250.0 + 1928.299 * 0.25 * centre.x / 1280.0, 1e-3);
    EXPECT_NEAR(spots[i].y, 240.0 + 1928.299 * 0.25 * centre.y / 768.0, 1e-3);
  }
}

TEST(Lattice, RefusesWhatTheSlmOrTheSensorCannotDo) {
  const auto changed = [](auto change) {
    SensorConfig sensor;
    change(sensor);
    return field_of_error(sensor);
  };
  EXPECT_EQ(changed([](auto& s) { s.pupil_diameter_px = 769.0; }), "sensor.pupil_diameter_px");
  EXPECT_EQ(changed([](auto& s) { s.pupil_diameter_px = 0.0; }), "sensor.pupil_diameter_px");
  EXPECT_EQ(changed([](auto& s) { s.pupil_diameter_px = std::nan(""); }),
            "sensor.pupil_diameter_px");
  EXPECT_EQ(changed([](auto& s) { s.subapertures_across = 0; }), "sensor.subapertures_across");
  EXPECT_EQ(changed([](auto& s) { s.subapertures_across = 1; }), "sensor.subapertures_across");
  EXPECT_EQ(changed([](auto& s) { s.subapertures_across = 61; }), "sensor.subapertures_across");
  EXPECT_EQ(changed([](auto& s) { s.subapertures_across = 1 << 30; }),
            "sensor.subapertures_across");
  EXPECT_EQ(changed([](auto& s) { s.grooves = {641.0, 20.0}; }), "sensor.grooves");
  EXPECT_EQ(changed([](auto& s) { s.grooves = {200.0, -385.0}; }), "sensor.grooves");
  EXPECT_EQ(changed([](auto& s) { s.spacing = 1.5; }), "sensor.grooves");
  EXPECT_EQ(changed([](auto& s) { s.spacing = std::nan(""); }), "sensor.grooves");
  EXPECT_EQ(changed([](auto&) {}), "no error");
}

}  // namespace
}  // namespace ovws
