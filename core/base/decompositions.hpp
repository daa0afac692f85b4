/// Decompositions of matrices, compiled once: Eigen's are templates that cost seconds in every file
/// that uses one. They allocate memory; core/base/cholesky.hpp does not.
#pragma once

#include <Eigen/Core>

namespace ovws {

/// x of a x = b, for a symmetric matrix (LDL^T decomposition). Only its lower triangle is read. A
/// singular matrix leaves what it does not determine at 0.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Cholesky decomposition of a positive definite matrix, of which only the lower triangle is read.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);

  /// Reciprocal condition number (1-norm, estimated); 0 if the matrix is not positive definite.
  /// Then solutions are NaN.
  double reciprocal_condition() const { return reciprocal_condition_; }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  Eigen::MatrixXd inverse() const;

 private:
  Eigen::MatrixXd lower_;
  double reciprocal_condition_ = 0.0;
};

/// x of least |a x - b|^2, and of these, if `a` does not determine it, the least x.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Orthonormal columns that span those of `a`. Columns that are sums of others up to the fraction
/// `least` of the longest one add nothing.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& a, double least = 1e-14);

/// Eigenvalues of a symmetric matrix, in increasing order, and their orthonormal eigenvectors. Only
/// its lower triangle is read.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;  ///< one in each column
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// Singular values, largest first, from the eigenvalues of a^T a: their errors are up to 1e-8 of
/// the largest.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);

/// a^T a.
Eigen::MatrixXd gram_matrix(const Eigen::MatrixXd& a);

}  // namespace ovws
