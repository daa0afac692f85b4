/// Diffractive matrices against the diffraction model.
#include "core/wavefront/diffractive_matrix.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <vector>

#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

class Diffractive : public testing::Test {
 protected:
  Diffractive()
      : model_(SensorModel::make(sensor_, {}, {}, 512, 512).value()),
        tracker_(make_tracker(tracking_, {sensor_.charge, model_.lambda_d_px()}).value()),
        modes_(18) {
    std::iota(modes_.begin(), modes_.end(), 1);
    geometric_ = slope_matrix(model_.lattice(), sensor_, modes_,
                              tilt_radius(sensor_.charge, tracking_), model_.px_per_cycle());
  }

  std::vector<SpotFix> fixes(Mode shown) {
    return model_fixes(model_, sensor_, *tracker_, {&shown, 1}).value();
  }

  SensorConfig sensor_;
  TrackingConfig tracking_;
  SensorModel model_;
  std::unique_ptr<const SpotTracker> tracker_;
  std::vector<int> modes_;
  Eigen::MatrixXd geometric_;
};

TEST_F(Diffractive, ReadsSmallModesThatItWasNotMadeWith) {
  // At 0.02 wave, less than the step it was made with: right to 5 %, and twice as good as geometry.
  const std::vector<int> some{8, 12, 17};
  const auto matrix = diffractive_matrix(model_, sensor_, *tracker_, some).value();
  ASSERT_EQ(matrix.slopes.rows(), 38);
  ASSERT_EQ(matrix.reference_px.size(), 19U);
  for (std::size_t k = 0; k < some.size(); ++k) {
    const auto moved = fixes({some[k], 0.02});
    Eigen::VectorXd seen(38);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      seen(2 * i) = double(moved[i].x) - matrix.reference_px[i].x;
      seen(2 * i + 1) = double(moved[i].y) - matrix.reference_px[i].y;
    }
    const double off = (seen - 0.02 * matrix.slopes.col(k)).norm() / seen.norm();
    const double geometric = (seen - 0.02 * geometric_.col(some[k] - 1)).norm() / seen.norm();
    std::printf("  j = %d: diffractive off by %.4f of the displacements, geometric by %.4f\n",
                some[k], off, geometric);
    EXPECT_LT(off, 0.05);
    EXPECT_LT(off, 0.5 * geometric);
  }
}

TEST_F(Diffractive, ASpotOutsideTheWindowIsAlwaysLost) {
  SensorModel narrow = SensorModel::make(sensor_, {}, {}, 512, 300).value();
  const std::vector<int> one{4};
  const auto matrix = diffractive_matrix(narrow, sensor_, *tracker_, one).value();
  EXPECT_TRUE(std::isnan(matrix.reference_px[0].x));
  EXPECT_EQ(matrix.slopes(0, 0), 0.0);
  EXPECT_TRUE(std::isfinite(matrix.reference_px[9].x));
  EXPECT_GT(matrix.slopes.norm(), 1.0);
}

TEST_F(Diffractive, WithoutSpotsIsRefused) {
  SensorModel tiny = SensorModel::make(sensor_, {}, {}, 20, 20).value();
  const std::vector<int> one{4};
  const auto matrix = diffractive_matrix(tiny, sensor_, *tracker_, one);
  ASSERT_FALSE(matrix);
  EXPECT_EQ(matrix.error().field, "tracking");
}

}  // namespace
}  // namespace ovws
