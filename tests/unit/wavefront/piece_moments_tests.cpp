/// PieceMoments: fast fields of single pieces against the propagation of the whole SLM.
#include "core/optics/piece_moments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics/hologram.hpp"
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

TEST(SensorField, IsTheModelsLightAroundTheSpotsButForItsCells) {
  SensorModel model = SensorModel::make({}, {}, {}, 512, 512).value();
  const Image<float> intensity = model.intensity(kModes).value();
  SensorField field = make_field(1);
  field.propagate(kModes, {});
  const PieceMoments moments(field, std::vector<int>{1});
  const float most = *std::max_element(intensity.pixels.begin(), intensity.pixels.end());
  double squares = 0.0, pixels = 0.0;
  for (std::size_t i = 0; i < 19; ++i) {
    const Vec2 at = moments.falls_px(i, kModes);
    const PixelBox box{int(at.x) - 36, int(at.y) - 36, 72, 72};  // 3 lambda/d to each side
    for (int y = box.y; y < box.y + box.height; ++y) {
      for (int x = box.x; x < box.x + box.width; ++x) {
        const double off = double((std::norm(field.far().at(x, y)) - intensity.at(x, y)) / most);
        ASSERT_NEAR(off, 0.0, 0.015) << x << ' ' << y;
        squares += off * off, pixels += 1.0;
      }
    }
  }
  EXPECT_LT(std::sqrt(squares / pixels), 0.001);
}

/// Every subaperture with this amplitude.
std::vector<SensorField::LocalField> amplitudes_of(double amplitude) {
  SensorField::LocalField field{};
  field[0] = amplitude - 1.0;
  return std::vector<SensorField::LocalField>(19, field);
}

class Piece : public testing::TestWithParam<int> {};

TEST_P(Piece, HasTheFieldThatGoesWhenItGoesDark) {
  SensorField field = make_field(GetParam());
  PieceMoments moments(field, std::vector<int>{1});
  for (const int i : {GetParam() == 1 ? 0 : 9}) {
    field.propagate(kModes, {});
    const auto with = field.far();
    moments.load(field, kModes, {&i, 1});
    auto dark = amplitudes_of(1.0);
    dark[std::size_t(i)][0] = -1.0;
    field.propagate(kModes, {.fields = dark});
    const PixelBox box = box_at(moments.falls_px(std::size_t(i), kModes));
    const auto& m = moments.at(i, box);
    const auto own = [&](int x, int y) { return with.at(x, y) - field.far().at(x, y); };
    EXPECT_LT(difference(box, own, [&](int k) { return m(k, 0); }), 0.003) << i;
  }
}

TEST_P(Piece, ChangesTheFieldByAPolynomialAsItsMomentsSay) {
  SensorField field = make_field(GetParam());
  PieceMoments moments(field, std::vector<int>{1});
  const int piece = 9;
  field.propagate(kModes, {});
  const auto before = field.far();
  moments.load(field, kModes, {&piece, 1});
  auto fields = amplitudes_of(1.0);
  Eigen::VectorXcf coefficients(PieceMoments::kCount);
  for (std::size_t k = 0; k < PieceMoments::kCount; ++k) {
    fields[piece][k] = {0.2 - 0.05 * double(k), 0.03 * double(k)};
    coefficients(Eigen::Index(k)) = std::complex<float>(fields[piece][k]);
  }
  field.propagate(kModes, {.fields = fields});
  const PixelBox box = box_at(moments.falls_px(std::size_t(piece), kModes));
  const Eigen::VectorXcf expected = moments.at(piece, box) * coefficients;
  const auto change = [&](int x, int y) { return field.far().at(x, y) - before.at(x, y); };
  EXPECT_LT(difference(box, change, [&](int p) { return expected(p); }), 0.01);
}
INSTANTIATE_TEST_SUITE_P(Charges, Piece, testing::Values(0, 1, 2));

TEST(PieceMoments, GiveHowAModeChangesTheField) {
  // Against central differences of the whole field, with one subaperture lit and no stray light.
  SensorField field = make_field(1);
  field.set_outside(false);
  const std::vector<int> modes_j{4, 12, 17};
  PieceMoments moments(field, modes_j);
  auto alone = amplitudes_of(0.0);
  alone[4][0] = 0.0;
  const int piece = 4;
  field.propagate(kModes, {.fields = alone});
  moments.load(field, kModes, {&piece, 1});
  const PixelBox box = box_at(moments.falls_px(4, kModes));
  const auto& m = moments.at(piece, box);
  constexpr double kStep = 0.005;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    std::vector<Mode> up = kModes, down = kModes;
    up.push_back({modes_j[k], kStep});
    down.push_back({modes_j[k], -kStep});
    field.propagate(up, {.fields = alone});
    const auto above = field.far();
    field.propagate(down, {.fields = alone});
    const auto change = [&](int x, int y) {
      return (above.at(x, y) - field.far().at(x, y)) / float(2.0 * kStep);
    };
    const Eigen::VectorXcf expected = Field(0.0F, 2.0F * std::numbers::pi_v<float>) *
                                      (m * moments.modes_over(piece).row(k).transpose());
    EXPECT_LT(difference(box, change, [&](int p) { return expected(p); }), 0.02) << modes_j[k];
  }
}

TEST(SensorField, CellsHoldEveryPixelOfThePupilOnce) {
  // In the middle of the window the light from outside the subapertures is exact.
  constexpr int kSize = 513, kMiddle = 256;
  SensorField field = SensorField::make({}, {}, {}, kSize, kSize).value();
  const auto dark = amplitudes_of(0.0);
  field.propagate({}, {.fields = dark});
  HologramConfig hologram;
  const HologramRenderer renderer = HologramRenderer::make(hologram).value();
  Image<std::uint8_t> grey;
  renderer.render(HologramKind::sensor, {}, grey);
  const FarFieldWindow& window = field.window();
  const Vec2 f = window.origin_cpp + (kMiddle * window.step_cpp) * Vec2{1.0, 1.0};
  const PupilCells& cells = field.cells();
  std::complex<double> sum;  // almost all of it cancels
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const Vec2 at{x - 0.5 * (grey.width - 1), y - 0.5 * (grey.height - 1)};
      const bool lit = std::none_of(
          cells.pieces.begin(), cells.pieces.begin() + cells.subapertures,
          [&](const PupilPiece& piece) { return norm(at - piece.centre_px) <= piece.radius_px; });
      const double cycles = grey.at(x, y) / 256.0 - f.x * at.x - f.y * at.y;
      if (lit) sum += std::polar(1.0, 2.0 * std::numbers::pi * cycles);
    }
  }
  const auto got = std::complex<double>(field.far().at(kMiddle, kMiddle));
  EXPECT_LT(std::abs(got - sum), 20.0) << got << sum;  // single precision
}

/// |F|^2 at a spatial frequency, by the sum over all pixels of the SLM.
double direct_light(const Image<std::uint8_t>& grey, Vec2 f_cpp) {
  std::complex<double> sum;
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const Vec2 at{x - 0.5 * (grey.width - 1), y - 0.5 * (grey.height - 1)};
      double waves = 0.0;
      if (norm(at) <= 384.0) {
        for (const Mode& mode : kModes) waves += mode.waves * zernike(mode.j, (1.0 / 384.0) * at);
      }
      const double cycles = grey.at(x, y) / 256.0 + waves - f_cpp.x * at.x - f_cpp.y * at.y;
      sum += std::polar(1.0, 2.0 * std::numbers::pi * cycles);
    }
  }
  return std::norm(sum);
}

class Turned : public testing::TestWithParam<PxPerCycle> {};

TEST_P(Turned, CameraSeesWhatTheSumOverAllPixelsTells) {
  OpticsConfig optics;
  optics.registered = GetParam();
  const PxPerCycle map = GetParam();
  SensorField field = SensorField::make({}, {}, optics, 512, 512).value();
  field.propagate(kModes, {});
  const PieceMoments moments(field, std::vector<int>{1});
  const HologramRenderer renderer = HologramRenderer::make(HologramConfig{}).value();
  Image<std::uint8_t> grey;
  renderer.render(HologramKind::sensor, {}, grey);
  const Vec2 base_cpp{200.0 / 1280.0, 20.0 / 768.0}, base_px{255.5, 255.5};
  float most = 0.0F;
  for (std::size_t spot = 0; spot < 19; ++spot) {
    const Vec2 at = moments.falls_px(spot, kModes);
    for (int k = 0; k < 17 * 17; ++k) {
      const int x = int(at.x) - 8 + k % 17, y = int(at.y) - 8 + k / 17;
      most = std::max(most, std::norm(field.far().at(x, y)));
    }
  }
  for (const std::size_t spot : {0, 9, 18}) {
    const Vec2 at = moments.falls_px(spot, kModes);
    for (const Vec2 off : {Vec2{0.0, 0.0}, Vec2{6.0, 0.0}, Vec2{-3.0, -7.0}}) {
      const int x = int(std::lround(at.x + off.x)), y = int(std::lround(at.y + off.y));
      const Vec2 px = Vec2{double(x), double(y)} - base_px;
      const double d = map.determinant();
      const Vec2 f{(map.yy * px.x - map.xy * px.y) / d, (map.xx * px.y - map.yx * px.x) / d};
      EXPECT_NEAR(double(std::norm(field.far().at(x, y)) / most),
                  direct_light(grey, base_cpp + f) / double(most), 0.015)
          << spot << ' ' << off.x << ' ' << off.y;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Cameras, Turned,
                         testing::Values(PxPerCycle(1926.0),
                                         PxPerCycle(1923.4, -100.8, 100.8, 1923.4),
                                         PxPerCycle(1100.0, 1580.0, 1600.0, -1090.0)));

TEST(SensorField, RunsOfAPieceLieInIt) {
  const SensorField field = make_field(1);
  const PupilCells& cells = field.cells();
  EXPECT_EQ(cells.grid.bin_px, 2);
  int last = 0;
  std::size_t next = 0;
  for (const CellRun& run : cells.runs) {
    EXPECT_GE(run.piece, last);
    EXPECT_EQ(run.first, next);
    last = run.piece;
    next += std::size_t(run.end - run.begin);
    const PupilPiece& piece = cells.pieces[std::size_t(run.piece)];
    for (int x = run.begin; x < run.end; ++x) {
      const Vec2 off = cells.grid.at_px(x, run.y) - piece.centre_px;
      EXPECT_LE(norm(off), piece.radius_px + 1.0);
    }
  }
  EXPECT_EQ(next, cells.light.size());
}

}  // namespace
}  // namespace ovws
