// Small dense quadratic programmes with bounds, for distributing contact forces.
#pragma once

#include <Eigen/Dense>

namespace atlas::sim {

constexpr int kMaxQpSize = 16;
using QpMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxQpSize, kMaxQpSize>;
using QpVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxQpSize, 1>;

/// Minimises x' H x / 2 + g' x over lower <= x <= upper by projected Newton steps, starting at `*x` (a warm
/// start). Returns the number of steps taken. @pre H symmetric positive definite, equal sizes up to
/// kMaxQpSize.
int SolveBoxQp(const QpMatrix& H, const QpVector& g, const QpVector& lower, const QpVector& upper,
               QpVector* x);

}  // namespace atlas::sim
