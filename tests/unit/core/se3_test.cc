#include "core/se3.h"

#include <gtest/gtest.h>

#include "core/rng.h"

namespace atlas::tests {
namespace {

using core::Mat6;
using core::Pose;
using core::Vec3;
using core::Vec6;

Vec6 RandomTwist(double angle, core::Rng* rng) {
  Vec6 xi;
  for (int k = 0; k < 6; ++k) xi[k] = rng->Normal();
  xi.tail<3>() *= angle / xi.tail<3>().norm();
  return xi;
}

/// The matrix exponential by its series, halved and squared.
Eigen::Matrix4d MatrixExponential(const Vec6& xi) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A << 0, -xi[5], xi[4], xi[0], xi[5], 0, -xi[3], xi[1], -xi[4], xi[3], 0, xi[2], 0, 0, 0, 0;
  A /= 1024.0;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = sum;
  for (int k = 1; k < 12; ++k) sum += term = (term * A / k).eval();
  for (int k = 0; k < 10; ++k) sum = (sum * sum).eval();
  return sum;
}

const std::vector<double> kAngles = {0.0,  1e-9, 1e-6, 9e-4, 1.1e-3, 0.01, 0.049,           0.051,
                                     0.29, 0.31, 1.0,  2.0,  3.0,    3.14, core::kPi - 1e-7};

TEST(Se3, ExpIsTheMatrixExponential) {
  core::Rng rng(1);
  for (const double angle : kAngles) {
    const Vec6 xi = RandomTwist(angle, &rng);
    EXPECT_LT((core::Exp(xi).matrix() - MatrixExponential(xi)).cwiseAbs().maxCoeff(), 1e-12) << angle;
  }
}

TEST(Se3, LogInvertsExpUpToHalfATurn) {
  core::Rng rng(2);
  for (const double angle : kAngles) {
    const Vec6 xi = RandomTwist(angle, &rng);
    EXPECT_LT((core::Log(core::Exp(xi)) - xi).norm(), 1e-7) << angle;
    EXPECT_LE(core::Log(core::Exp(1.5 * xi)).tail<3>().norm(), core::kPi + 1e-12) << angle;
  }
}

TEST(Se3, AdjointMovesAPerturbationToTheOtherSide) {
  core::Rng rng(3);
  for (const double angle : kAngles) {
    const Pose T = core::Exp(RandomTwist(angle, &rng));
    const Vec6 xi = RandomTwist(0.7, &rng);
    const Pose left = T * core::Exp(xi) * T.inverse(), right = core::Exp(core::Adjoint(T) * xi);
    EXPECT_LT((left.matrix() - right.matrix()).cwiseAbs().maxCoeff(), 1e-12) << angle;
  }
}

TEST(Se3, RightJacobianInverseIsTheDerivativeOfLog) {
  core::Rng rng(4);
  constexpr double kStep = 1e-6;
  for (const double angle : kAngles) {
    if (angle > 3.1) continue;  // differences would cross half a turn
    const Vec6 xi = RandomTwist(angle, &rng);
    const Pose T = core::Exp(xi);
    Mat6 numeric;
    for (int k = 0; k < 6; ++k) {
      const Vec6 d = kStep * Vec6::Unit(k);
      numeric.col(k) = (core::Log(T * core::Exp(d)) - core::Log(T * core::Exp(-d))) / (2.0 * kStep);
    }
    EXPECT_LT((core::RightJacobianInverse(xi) - numeric).cwiseAbs().maxCoeff(), 1e-7) << angle;
  }
}

}  // namespace
}  // namespace atlas::tests
