/// Products of small complex matrices and of lines in vectors of the CPU's full width, which
/// Eigen's product uses only if the whole program is built for that CPU.
#pragma once

#include <Eigen/Core>
#include <complex>

namespace ovws {

/// Column-major complex matrix: `stride` numbers from one column to the next.
struct ComplexColumns {
  const std::complex<float>* first;
  int rows, columns, stride;
};

/// Least number of rows of a product.
constexpr int kMinProductRows = 8;

/// out = a b^T. `a` has at least kMinProductRows rows, `out` the rows of `a` and as many columns as
/// `b` has rows. `out` must not overlap the others.
void multiply_by_transposed(const Eigen::Ref<const Eigen::MatrixXcf>& a,
                            const Eigen::Ref<const Eigen::MatrixXcf>& b,
                            Eigen::Ref<Eigen::MatrixXcf> out);

/// out[k] = a[k] b[k], for k = 0 … count - 1. `out` may be `a` or `b`.
void multiply_each(const std::complex<float>* a, const std::complex<float>* b, int count,
                   std::complex<float>* out);

}  // namespace ovws
