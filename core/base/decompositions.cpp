#include "core/base/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <limits>

namespace ovws {

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return solve_symmetric(a, Eigen::MatrixXd(b));
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

Cholesky::Cholesky(const Eigen::MatrixXd& a) {
  const Eigen::LLT<Eigen::MatrixXd> factors(a);
  const bool is_definite = factors.info() == Eigen::Success;
  reciprocal_condition_ = is_definite ? factors.rcond() : 0.0;
  lower_ = factors.matrixLLT();
  if (!is_definite) lower_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

Eigen::MatrixXd Cholesky::solve(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd x = b;
  lower_.triangularView<Eigen::Lower>().solveInPlace(x);
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

Eigen::MatrixXd Cholesky::inverse() const {
  return solve(Eigen::MatrixXd::Identity(lower_.rows(), lower_.cols()));
}

Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return least_squares(a, Eigen::MatrixXd(b));
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& a, double least) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(a.rows(), a.cols());
  factors.setThreshold(least).compute(a);
  return factors.householderQ() * Eigen::MatrixXd::Identity(a.rows(), factors.rank());
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(a);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& a) {
  return symmetric_eigenvalues(gram_matrix(a)).reverse().cwiseMax(0.0).cwiseSqrt();
}

Eigen::MatrixXd gram_matrix(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(a.cols(), a.cols());
  product.selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  product.triangularView<Eigen::StrictlyUpper>() = product.transpose();
  return product;
}

}  // namespace ovws
