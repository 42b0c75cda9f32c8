#include "core/se3.h"

namespace atlas::core {
namespace {

constexpr double kSmallAngle = 1e-3;  ///< below, series: their next term is under 1e-14 of the first

/// (1 - cos a) / a^2, (a - sin a) / a^3 and (1 - (a/2) cot(a/2)) / a^2.
struct Coefficients {
  double versine, sine, cotangent;
};

Coefficients CoefficientsOf(double angle) {
  const double a2 = angle * angle;
  if (angle < kSmallAngle) return {0.5 - a2 / 24.0, 1.0 / 6.0 - a2 / 120.0, 1.0 / 12.0 + a2 / 720.0};
  const double half_sine = std::sin(0.5 * angle);
  return {2.0 * half_sine * half_sine / a2, (angle - std::sin(angle)) / (a2 * angle),
          (1.0 - 0.5 * angle * std::cos(0.5 * angle) / half_sine) / a2};
}

Mat3 LeftJacobianSo3(const Vec3& phi) {
  const Coefficients c = CoefficientsOf(phi.norm());
  const Mat3 W = Skew(phi);
  return Mat3::Identity() + c.versine * W + c.sine * W * W;
}

/// Barfoot Eq. 7.86: the lower left block of the left Jacobian, here with translation first the upper right.
Mat3 CouplingOf(const Vec3& rho, const Vec3& phi) {
  const double a = phi.norm(), a2 = a * a;
  const Mat3 P = Skew(rho), W = Skew(phi);
  // The differences of the last two coefficients cancel at larger angles than those of the Jacobian.
  const bool small = a < 0.05;
  const double b1 = CoefficientsOf(a).sine;
  const double b2 =
      small ? 1.0 / 24.0 - a2 / 720.0 + a2 * a2 / 40320.0 : (0.5 * a2 + std::cos(a) - 1.0) / (a2 * a2);
  const double b3 = small ? 1.0 / 120.0 - a2 / 2520.0 + a2 * a2 / 120960.0
                          : 0.5 * (b2 + 3.0 * (a - std::sin(a) - a2 * a / 6.0) / (a2 * a2 * a));
  return 0.5 * P + b1 * (W * P + P * W + W * P * W) + b2 * (W * W * P + P * W * W - 3.0 * W * P * W) +
         b3 * (W * P * W * W + W * W * P * W);
}

}  // namespace

Mat3 Skew(const Vec3& a) {
  Mat3 W;
  W << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return W;
}

Mat3 ExpSo3(const Vec3& phi) {
  const double half = 0.5 * phi.norm();
  const double scale = half < kSmallAngle ? 0.5 - half * half / 12.0 : 0.5 * std::sin(half) / half;
  Eigen::Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = scale * phi;
  return q.normalized().toRotationMatrix();
}

Vec3 LogSo3(const Mat3& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-9) return 2.0 * q.vec();
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

Mat3 RightJacobianInverseSo3(const Vec3& phi) {
  const Mat3 W = Skew(phi);
  return Mat3::Identity() + 0.5 * W + CoefficientsOf(phi.norm()).cotangent * W * W;
}

Pose Exp(const Vec6& xi) {
  return MakePose(ExpSo3(xi.tail<3>()), LeftJacobianSo3(xi.tail<3>()) * xi.head<3>());
}

Vec6 Log(const Pose& T) {
  const Vec3 phi = LogSo3(T.linear());
  Vec6 xi;
  // The inverse of the left Jacobian is that of the right one at -phi.
  xi << RightJacobianInverseSo3(-phi) * T.translation(), phi;
  return xi;
}

Mat6 Adjoint(const Pose& T) {
  Mat6 A;
  A << T.linear(), Skew(T.translation()) * T.linear(), Mat3::Zero(), T.linear();
  return A;
}

Mat6 RightJacobianInverse(const Vec6& xi) {
  // Barfoot Eq. 7.95 for the left one; the right one at xi is the left one at -xi.
  const Vec3 rho = -xi.head<3>(), phi = -xi.tail<3>();
  const Mat3 J = RightJacobianInverseSo3(-phi);
  Mat6 inverse;
  inverse << J, -J * CouplingOf(rho, phi) * J, Mat3::Zero(), J;
  return inverse;
}

}  // namespace atlas::core
