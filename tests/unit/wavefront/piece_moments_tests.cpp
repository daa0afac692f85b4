/// PieceMoments: fast fields of single pieces against the propagation of the whole SLM.
#include "core/optics/piece_moments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics/sensor_model.hpp"

namespace ovws {
namespace {

const std::vector<Mode> kModes{{3, 0.2}, {8, -0.2}, {12, 0.2}, {16, 0.1}};
using Field = std::complex<float>;

SensorField make_field(int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  return SensorField::make(sensor, {}, {}, 512, 512).value();
}

PixelBox box_at(Vec2 at) {
  return {int(at.x) - 50, int(at.y) - 50, 100, 90};
}

/// Largest difference in the box, relative to the largest of `expected` there.
double difference(const PixelBox& box, const auto& expected, const auto& got) {
  double most = 0.0, off = 0.0;
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const Field e = expected(box.x + x, box.y + y);
      most = std::max(most, double(std::abs(e)));
      off = std::max(off, double(std::abs(e - got(y * box.width + x))));
    }
  }
  return off / most;
}

TEST(SensorField, IsTheModelsLightButForItsRounding) {
  SensorModel model = SensorModel::make({}, {}, {}, 512, 512).value();
  const Image<float> intensity = model.intensity(kModes).value();
  SensorField field = make_field(1);
  field.propagate(kModes, {});
  const float most = *std::max_element(intensity.pixels.begin(), intensity.pixels.end());
  for (std::size_t k = 0; k < intensity.pixels.size(); ++k) {
    ASSERT_NEAR(std::norm(field.far().pixels[k]) / most, intensity.pixels[k] / most, 0.01);
  }
}

class Piece : public testing::TestWithParam<int> {};

TEST_P(Piece, HasTheFieldThatGoesWhenItGoesDark) {
  SensorField field = make_field(GetParam());
  PieceMoments moments(field, std::vector<int>{1});
  for (const int i : {GetParam() == 1 ? 0 : 9}) {
    field.propagate(kModes, {});
    const auto with = field.far();
    moments.load(field, kModes, {&i, 1});
    std::vector<double> amplitudes(19, 1.0);
    amplitudes[std::size_t(i)] = 0.0;
    field.propagate(kModes, {.amplitudes = amplitudes});
    const PixelBox box = box_at(moments.falls_px(std::size_t(i), kModes));
    const auto& m = moments.at(i, box);
    const auto own = [&](int x, int y) { return with.at(x, y) - field.far().at(x, y); };
    EXPECT_LT(difference(box, own, [&](int k) { return m(k, 0); }), 0.003) << i;
  }
}
INSTANTIATE_TEST_SUITE_P(Charges, Piece, testing::Values(0, 1, 2));

TEST(PieceMoments, TellHowAModeChangesTheField) {
  // Against central differences of the whole field, with one subaperture lit and no stray light.
  SensorField field = make_field(1);
  field.set_outside(false);
  const std::vector<int> modes_j{4, 12, 17};
  PieceMoments moments(field, modes_j);
  std::vector<double> alone(19, 0.0);
  alone[4] = 1.0;
  const int piece = 4;
  field.propagate(kModes, {.amplitudes = alone});
  moments.load(field, kModes, {&piece, 1});
  const PixelBox box = box_at(moments.falls_px(4, kModes));
  const auto& m = moments.at(piece, box);
  constexpr double kStep = 0.005;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    std::vector<Mode> up = kModes, down = kModes;
    up.push_back({modes_j[k], kStep});
    down.push_back({modes_j[k], -kStep});
    field.propagate(up, {.amplitudes = alone});
    const auto above = field.far();
    field.propagate(down, {.amplitudes = alone});
    const auto change = [&](int x, int y) {
      return (above.at(x, y) - field.far().at(x, y)) / float(2.0 * kStep);
    };
    const Eigen::VectorXcf expected = Field(0.0F, 2.0F * std::numbers::pi_v<float>) *
                                      (m * moments.modes_over(piece).row(k).transpose());
    EXPECT_LT(difference(box, change, [&](int p) { return expected(p); }), 0.02) << modes_j[k];
  }
}

TEST(SensorField, CutsEveryPixelOfThePupilOnceAndNoOther) {
  const SensorField field = make_field(1);
  std::vector<int> count(1280 * 768, 0);
  int last = 0;
  for (const SensorField::Run& run : field.runs()) {
    EXPECT_GE(run.piece, last);
    last = run.piece;
    const auto& piece = field.pieces()[std::size_t(run.piece)];
    for (int x = run.begin; x < run.end; ++x) {
      ++count[std::size_t(run.y) * 1280 + std::size_t(x)];
      const Vec2 at = Vec2{double(x), double(run.y)} - field.pupil_centre_px() - piece.centre_px;
      EXPECT_LE(norm(at), piece.radius_px + 1e-9);
    }
  }
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const bool in = norm(Vec2{double(x), double(y)} - field.pupil_centre_px()) <= 384.0;
      ASSERT_EQ(count[std::size_t(y) * 1280 + std::size_t(x)], in ? 1 : 0) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace ovws
