/// Products of complex matrices are those of Eigen, for any sizes, strides and instruction sets.
#include "core/optics/complex_matrices.hpp"

#include <gtest/gtest.h>

#include "tests/support/every_target.hpp"

namespace ovws {
namespace {

TEST(ComplexMatrices, MultiplyAsEigenDoes) {
  for (const int rows : {kMinProductRows, 9, 15, 16, 29, 64}) {
    for (const int inner : {1, 7, 36}) {
      for (const int columns : {1, 3, 4, 18, 29}) {
        const Eigen::MatrixXcf a = Eigen::MatrixXcf::Random(rows, inner);
        const Eigen::MatrixXcf b = Eigen::MatrixXcf::Random(columns, inner);
        const Eigen::MatrixXcf right = a * b.transpose();
        test::with_every_target([&] {
          Eigen::MatrixXcf product(rows, columns);
          multiply_by_transposed(a, b, product);
          EXPECT_LT((product - right).norm(), 1e-6F * float(inner) * right.norm())
              << rows << " x " << inner << " x " << columns;
        });
      }
    }
  }
}

TEST(ComplexMatrices, MayBePartsOfLargerOnes) {
  const Eigen::MatrixXcf a = Eigen::MatrixXcf::Random(40, 12), b = Eigen::MatrixXcf::Random(30, 12);
  const Eigen::MatrixXcf right = a.middleRows(5, 20) * b.middleRows(3, 10).transpose();
  test::with_every_target([&] {
    Eigen::MatrixXcf all = Eigen::MatrixXcf::Zero(25, 14);
    multiply_by_transposed(a.middleRows(5, 20), b.middleRows(3, 10), all.block(2, 2, 20, 10));
    EXPECT_LT((all.block(2, 2, 20, 10) - right).norm(), 1e-5F * right.norm());
    all.block(2, 2, 20, 10).setZero();
    EXPECT_EQ(all.norm(), 0.0F);
  });
}

}  // namespace
}  // namespace ovws
