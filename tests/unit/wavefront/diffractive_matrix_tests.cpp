/// Diffractive matrices against the diffraction model.
#include "core/wavefront/diffractive_matrix.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <vector>

#include "core/optics/sensor_model.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

class Diffractive : public testing::Test {
 protected:
  Diffractive() : geometric_{OperatorKind::slopes, std::vector<int>(18), {}} {
    std::iota(geometric_.modes_j.begin(), geometric_.modes_j.end(), 1);
    geometric_.slopes = slope_matrix(lattice_, sensor_, geometric_.modes_j,
                                     tilt_radius(sensor_.charge, {}), px_per_cycle({}, {}));
  }

  Result<ModeOperator> made(int cols, int rows, const OpticsConfig& optics = {}) const {
    SensorField field = SensorField::make(sensor_, {}, optics, cols, rows).value();
    ModeOperator slopes = geometric_;
    slopes.slopes = slope_matrix(lattice_, sensor_, geometric_.modes_j,
                                 tilt_radius(sensor_.charge, {}), px_per_cycle(optics, {}));
    return diffractive_operator(field, *tracker_, slopes,
                                model_spots_px(lattice_, sensor_, {}, optics, cols, rows));
  }

  /// Displacements that the tracker finds in another model, whose wavefront has 8 bits.
  Eigen::VectorXd moved(Mode shown) const {
    SensorModel model = SensorModel::make(sensor_, {}, {}, 512, 512).value();
    const Eigen::VectorXd by = shown.waves * geometric_.slopes.col(shown.j - 1);
    return fixes(model, {&shown, 1}, by) - fixes(model, {}, Eigen::VectorXd::Zero(38));
  }

  Eigen::VectorXd fixes(SensorModel& model, std::span<const Mode> modes,
                        const Eigen::VectorXd& by) const {
    const Image<float> light = model.intensity(modes).value();
    Image<std::uint16_t> image(light.width, light.height);
    const float peak = *std::max_element(light.pixels.begin(), light.pixels.end());
    std::transform(light.pixels.begin(), light.pixels.end(), image.pixels.begin(),
                   [peak](float value) { return std::uint16_t(60000.0F / peak * value); });
    TrackScratch scratch = tracker_->make_scratch();
    Eigen::VectorXd at(38);
    for (Eigen::Index i = 0; i < 19; ++i) {
      const Vec2 start = model.spots_px()[std::size_t(i)] + Vec2{by(2 * i), by(2 * i + 1)};
      const SpotFix fix = tracker_->track(view_of(image, PixelFormat::mono16), start, scratch);
      at.segment<2>(2 * i) << double(fix.x), double(fix.y);
    }
    return at;
  }

  SensorConfig sensor_;
  Lattice lattice_ = make_lattice(sensor_, {}).value();
  std::unique_ptr<const SpotTracker> tracker_ =
      make_tracker({}, {sensor_.charge, lambda_d_px({}, {}, sensor_)}).value();
  ModeOperator geometric_;
};

TEST_F(Diffractive, ReadsSmallModesOfAnotherModel) {
  // At 0.02 wave, less than the step it was made with: right to 5 %, and twice as good as geometry.
  const auto matrix = made(512, 512).value();
  EXPECT_EQ(matrix.kind, OperatorKind::diffractive);
  EXPECT_EQ(matrix.modes_j, geometric_.modes_j);
  ASSERT_EQ(matrix.flat_px.size(), 19U);
  for (const int j : {8, 12, 17}) {
    const Eigen::VectorXd seen = moved({j, 0.02});
    const double off = (seen - 0.02 * matrix.slopes.col(j - 1)).norm() / seen.norm();
    const double geometric = (seen - 0.02 * geometric_.slopes.col(j - 1)).norm() / seen.norm();
    std::printf("  j = %d: diffractive off by %.4f of the displacements, geometric by %.4f\n", j,
                off, geometric);
    EXPECT_LT(off, 0.05);
    EXPECT_LT(off, 0.5 * geometric);
  }
}

TEST_F(Diffractive, IsThatOfATurnedCamera) {
  const double s = px_per_cycle({}, {}).scale();
  OpticsConfig turned;
  turned.registered = PxPerCycle{0.0, -s, s, 0.0};  // +x of the SLM is +y of the camera
  const Eigen::MatrixXd straight = made(512, 512).value().slopes;
  const Eigen::MatrixXd matrix = made(512, 512, turned).value().slopes;
  ASSERT_EQ(matrix.rows(), straight.rows());
  Eigen::MatrixXd back(matrix.rows(), matrix.cols());
  for (Eigen::Index i = 0; i < matrix.rows(); i += 2) {
    back.row(i) = matrix.row(i + 1);
    back.row(i + 1) = -matrix.row(i);
  }
  EXPECT_LT((back - straight).norm(), 0.01 * straight.norm());
}

TEST_F(Diffractive, ASpotOutsideTheImageIsAlwaysLost) {
  geometric_.modes_j.resize(5);
  const auto matrix = made(512, 300).value();
  EXPECT_TRUE(std::isnan(matrix.flat_px[0].x));
  EXPECT_EQ(matrix.slopes(0, 0), 0.0);
  EXPECT_TRUE(std::isfinite(matrix.flat_px[9].x));
  EXPECT_GT(matrix.slopes.norm(), 1.0);
}

TEST_F(Diffractive, WithoutSpotsIsRefused) {
  const auto matrix = made(20, 20);
  ASSERT_FALSE(matrix);
  EXPECT_EQ(matrix.error().field, "tracking");
}

}  // namespace
}  // namespace ovws
