/// The fit of spiral plates recovers the depth and the shift that images were rendered with.
#include "core/spots/plate_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/optics/sensor_field.hpp"

namespace ovws {
namespace {

constexpr int kCols = 260, kRows = 250, kAcross = 7;

/// 7 x 7 square lenslets of 30 pixels with spiral plates, lambda/pitch 4 pixels.
struct PlateCase {
  SensorConfig sensor;
  SlmGeometry slm{16, 16, 5.3};
  OpticsConfig optics;

  explicit PlateCase(int charge, int levels) {
    sensor.charge = charge;
    sensor.grooves = {0.0, 0.0};
    sensor.pupil_diameter_px = 30.0 * kAcross;
    sensor.subapertures_across = kAcross;
    sensor.lenslets = {LensletShape::square, 30.0, 0.0, {levels, 1.0, {}}, 120.0, {}};
    for (int k = 0; k < kAcross * kAcross; ++k) {
      sensor.lenslets.centres_px.push_back(
          {30.0 * (k % kAcross - kAcross / 2), 30.0 * (k / kAcross - kAcross / 2)});
    }
    optics.registered = PxPerCycle(120.0);
    optics.centre_px = Vec2{129.3, 124.6};
  }

  std::vector<Vec2> places() const {
    std::vector<Vec2> all;
    for (const Vec2 at : sensor.lenslets.centres_px) all.push_back(*optics.centre_px + at);
    return all;
  }

  /// Mean image with noise of 0.5 % of the peak, 1000 DN above a background of 20 DN.
  Image<float> image(const SpiralPlate& plate, const std::vector<Mode>& light) const {
    SensorConfig real = sensor;
    real.lenslets.plate = plate;
    auto field = SensorField::make(real, slm, optics, kCols, kRows).value();
    field.propagate(light, {});
    Image<float> out(kCols, kRows);
    float peak = 0.0F;
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kCols; ++x) {
        out.at(x, y) = std::norm(field.far().row(y)[x]);
        peak = std::max(peak, out.at(x, y));
      }
    }
    std::mt19937 random(5);
    std::normal_distribution<float> noise(20.0F, 5.0F);
    for (float& value : out.pixels) value = 1000.0F * value / peak + noise(random);
    return out;
  }

  Result<PlateFit> fit(const Image<float>& image) const {
    return fit_plate(image, sensor, slm, optics, {}, places(), [] { return false; });
  }
};

TEST(PlateFit, RecoversDepthAndShift) {
  const std::vector<Mode> light{{1, 0.2}, {2, -0.1}, {4, 0.25}, {5, -0.1}, {8, 0.05}};
  for (const SpiralPlate& made :
       {SpiralPlate{16, 1.05, {0.6, -0.3}}, SpiralPlate{16, 0.9, {-1.0, 0.5}}}) {
    const PlateCase array(1, 16);
    const auto fit = array.fit(array.image(made, light));
    ASSERT_TRUE(fit) << fit.error().reason;
    EXPECT_NEAR(fit->plate.depth, made.depth, 0.004);
    EXPECT_NEAR(fit->plate.shift_px.x, made.shift_px.x, 0.03);
    EXPECT_NEAR(fit->plate.shift_px.y, made.shift_px.y, 0.03);
    EXPECT_LT(fit->depth_standard_error, 0.002);
    EXPECT_LT(fit->misfit, 0.1);
  }
}

TEST(PlateFit, SaysWhatIsMissing) {
  PlateCase array(1, 16);
  const Image<float> image = array.image({16, 1.0, {}}, {});
  const std::vector<Vec2> lost(array.sensor.lenslets.centres_px.size(), Vec2{NAN, NAN});
  const auto never = [] { return false; };
  const auto none = fit_plate(image, array.sensor, array.slm, array.optics, {}, lost, never);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().field, "camera");
  const auto stopped = fit_plate(image, array.sensor, array.slm, array.optics, {}, array.places(),
                                 [] { return true; });
  ASSERT_FALSE(stopped);
  array.sensor.charge = 0;
  EXPECT_EQ(array.fit(image).error().field, "sensor.charge");
}

}  // namespace
}  // namespace ovws
