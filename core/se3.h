// The Lie group SE(3): tangent vectors are [translation; rotation], perturbations act on the right,
// T = T_mean * Exp(xi) (thesis Eq. 4.8). Formulas after Barfoot, "State Estimation for Robotics", ch. 7.
#pragma once

#include "core/geometry.h"

namespace atlas::core {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// The matrix of the cross product: Skew(a) * b = a x b.
Mat3 Skew(const Vec3& a);

Mat3 ExpSo3(const Vec3& phi);
/// The rotation vector, of length at most pi.
Vec3 LogSo3(const Mat3& R);
/// Log(Exp(phi) Exp(d)) = phi + J d for small d. @pre |phi| < 2 pi.
Mat3 RightJacobianInverseSo3(const Vec3& phi);

Pose Exp(const Vec6& xi);
/// Exp(Log(T)) = T; the rotation part is at most pi long.
Vec6 Log(const Pose& T);
/// T Exp(xi) T^-1 = Exp(Adjoint(T) xi) (thesis Eq. 4.9).
Mat6 Adjoint(const Pose& T);
/// Log(Exp(xi) Exp(d)) = xi + J d for small d. @pre its rotation part is shorter than 2 pi.
Mat6 RightJacobianInverse(const Vec6& xi);

}  // namespace atlas::core
