/// Decompositions: their solutions, and what they say about a matrix that determines none.
#include "core/base/decompositions.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/cholesky.hpp"

namespace ovws {
namespace {

constexpr double kRounding = 1e-14;

/// Positive definite.
Eigen::MatrixXd definite() {
  return Eigen::Matrix3d{{4.0, 1.0, -2.0}, {1.0, 3.0, 0.5}, {-2.0, 0.5, 5.0}};
}

/// The third column is the sum of the others.
Eigen::MatrixXd dependent() {
  return Eigen::MatrixXd{{1.0, 0.0, 1.0}, {0.0, 2.0, 2.0}, {1.0, 1.0, 2.0}, {0.0, -1.0, -1.0}};
}

double largest(const Eigen::MatrixXd& matrix) {
  return matrix.cwiseAbs().maxCoeff();
}

TEST(Decompositions, SolveASymmetricMatrixThatIsNotDefinite) {
  const Eigen::MatrixXd a = Eigen::Matrix2d{{1.0, 3.0}, {3.0, 1.0}};
  const Eigen::VectorXd x = Eigen::Vector2d{2.0, -1.0};
  const Eigen::VectorXd b = a.lazyProduct(x);
  EXPECT_LT(largest(solve_symmetric(a, b) - x), kRounding);
}

TEST(Decompositions, LeaveWhatASingularMatrixDoesNotDetermineAtZero) {
  const Eigen::MatrixXd a = Eigen::Vector3d{2.0, 0.0, 4.0}.asDiagonal();
  const Eigen::VectorXd b = Eigen::Vector3d{2.0, 0.0, 2.0};
  const Eigen::VectorXd x = Eigen::Vector3d{1.0, 0.0, 0.5};
  EXPECT_LT(largest(solve_symmetric(a, b) - x), kRounding);
}

TEST(Decompositions, InvertAPositiveDefiniteMatrix) {
  const Eigen::MatrixXd a = definite();
  const Cholesky factors(a);
  EXPECT_GT(factors.reciprocal_condition(), 0.1);
  EXPECT_LT(largest(a.lazyProduct(factors.inverse()) - Eigen::MatrixXd::Identity(3, 3)), kRounding);
}

TEST(Decompositions, HaveNoCholeskyFactorOfAnIndefiniteMatrix) {
  const Cholesky factors(Eigen::Matrix2d{{1.0, 3.0}, {3.0, 1.0}});
  EXPECT_EQ(factors.reciprocal_condition(), 0.0);
  EXPECT_TRUE(std::isnan(factors.inverse()(0, 0)));
}

TEST(Decompositions, FindTheLeastOfManyLeastSquaresSolutions) {
  const Eigen::MatrixXd a = dependent();
  const Eigen::VectorXd x = Eigen::Vector3d{1.0, 2.0, 3.0};  // orthogonal to (1, 1, -1)
  const Eigen::VectorXd b = a.lazyProduct(x);
  EXPECT_LT(largest(least_squares(a, b) - x), 10.0 * kRounding);
}

TEST(Decompositions, SpanTheColumnsByOrthonormalOnes) {
  const Eigen::MatrixXd a = dependent();
  const Eigen::MatrixXd basis = orthonormal_basis(a);
  ASSERT_EQ(basis.cols(), 2);
  EXPECT_LT(largest(gram_matrix(basis) - Eigen::MatrixXd::Identity(2, 2)), kRounding);
  const Eigen::MatrixXd parts = basis.transpose().lazyProduct(a);
  EXPECT_LT(largest(a - basis.lazyProduct(parts)), 10.0 * kRounding);
}

TEST(Decompositions, FindEigenvaluesInIncreasingOrder) {
  const Eigen::MatrixXd a = definite();
  const auto [values, vectors] = symmetric_eigen(a);
  EXPECT_LT(values(0), values(1));
  EXPECT_LT(values(1), values(2));
  const Eigen::MatrixXd scaled = vectors * values.asDiagonal();
  EXPECT_LT(largest(a.lazyProduct(vectors) - scaled), 10.0 * kRounding);
  EXPECT_LT(largest(symmetric_eigenvalues(a) - values), 10.0 * kRounding);
}

TEST(Decompositions, FindSingularValuesLargestFirst) {
  const Eigen::MatrixXd a{{0.0, 3.0}, {0.0, 4.0}, {2.0, 0.0}};
  const Eigen::VectorXd expected = Eigen::Vector2d{5.0, 2.0};
  EXPECT_LT(largest(singular_values(a) - expected), 10.0 * kRounding);
}

TEST(CholeskyInPlace, SolvesAPositiveDefiniteMatrix) {
  Eigen::Matrix3d factor = definite();
  const Eigen::Matrix<double, 3, 2> x{{1.0, -2.0}, {0.5, 3.0}, {-1.0, 4.0}};
  Eigen::Matrix<double, 3, 2> b = factor.lazyProduct(x);
  ASSERT_TRUE(solve_positive(factor, b));
  EXPECT_LT(largest(b - x), 10.0 * kRounding);
  Eigen::Matrix3d singular = Eigen::Vector3d{1.0, 0.0, 1.0}.asDiagonal();
  EXPECT_FALSE(solve_positive(singular, b));
}

}  // namespace
}  // namespace ovws
