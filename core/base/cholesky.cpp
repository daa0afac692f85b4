#include "core/base/cholesky.hpp"

#include <cmath>

namespace ovws {

bool factorise(Eigen::Ref<Eigen::MatrixXd> a) {
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    const double before = a(j, j);
    for (Eigen::Index k = 0; k < j; ++k) a(j, j) -= a(j, k) * a(j, k);
    // A pivot at the rounding error means a singular matrix.
    if (!(a(j, j) > 1e-12 * before)) return false;
    a(j, j) = std::sqrt(a(j, j));
    for (Eigen::Index i = j + 1; i < a.rows(); ++i) {
      for (Eigen::Index k = 0; k < j; ++k) a(i, j) -= a(i, k) * a(j, k);
      a(i, j) /= a(j, j);
    }
  }
  return true;
}

void invert_lower(Eigen::Ref<Eigen::MatrixXd> l) {
  for (Eigen::Index j = 0; j < l.cols(); ++j) {
    l(j, j) = 1.0 / l(j, j);
    for (Eigen::Index i = j + 1; i < l.rows(); ++i) {
      double sum = 0.0;
      for (Eigen::Index k = j; k < i; ++k) sum += l(i, k) * l(k, j);
      l(i, j) = -sum / l(i, i);
    }
  }
}

bool invert_positive(Eigen::Ref<Eigen::MatrixXd> a) {
  if (!factorise(a)) return false;
  invert_lower(a);
  // L^-T L^-1, lower triangle first: row i of the product needs only rows i and below of L^-1.
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (Eigen::Index k = i; k < a.rows(); ++k) sum += a(k, i) * a(k, j);
      a(i, j) = sum;
    }
  }
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) a(j, i) = a(i, j);
  }
  return true;
}

bool solve_positive(Eigen::Ref<Eigen::MatrixXd> a, Eigen::Ref<Eigen::MatrixXd> b) {
  if (!factorise(a)) return false;
  const Eigen::Index last = a.rows() - 1;
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index i = 0; i <= last; ++i) {
      for (Eigen::Index k = 0; k < i; ++k) b(i, c) -= a(i, k) * b(k, c);
      b(i, c) /= a(i, i);
    }
    for (Eigen::Index i = last; i >= 0; --i) {
      for (Eigen::Index k = i + 1; k <= last; ++k) b(i, c) -= a(k, i) * b(k, c);
      b(i, c) /= a(i, i);
    }
  }
  return true;
}

}  // namespace ovws
