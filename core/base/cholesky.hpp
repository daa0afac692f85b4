/// Cholesky decomposition that never allocates memory; Eigen's own may, for large matrices.
#pragma once

#include <Eigen/Core>

#include "core/base/realtime.hpp"

namespace ovws {

/// In-place Cholesky factorisation of the lower triangle; false if the matrix is not positive
/// definite. RT-safe.
bool factorise(Eigen::Ref<Eigen::MatrixXd> a) OVWS_NONBLOCKING;

/// In-place inverse of a lower triangle. RT-safe.
void invert_lower(Eigen::Ref<Eigen::MatrixXd> l) OVWS_NONBLOCKING;

/// In-place inverse; false if the matrix is not positive definite. RT-safe.
bool invert_positive(Eigen::Ref<Eigen::MatrixXd> a) OVWS_NONBLOCKING;

/// Solves a x = b, with x in place of `b`; false if the matrix is not positive definite. `a`
/// becomes its factor. RT-safe.
bool solve_positive(Eigen::Ref<Eigen::MatrixXd> a, Eigen::Ref<Eigen::MatrixXd> b) OVWS_NONBLOCKING;

}  // namespace ovws
