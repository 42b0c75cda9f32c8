#include "mapping/slam/edge_terms.h"

#include <cmath>

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Mat6;
using core::Pose;
using core::Vec3;

/// With E = T_from_to^-1 T_map_from^-1 T_map_to, the derivative of an error by E Exp(d) is that by d_to; and
/// Exp(-d_from) moves through T_map_from^-1 T_map_to as -Ad(T_map_to^-1 T_map_from) d_from.
Mat6 ByFrom(const Mat6& by_to, const Pose& T_map_from, const Pose& T_map_to) {
  return -by_to * core::Adjoint(T_map_to.inverse() * T_map_from);
}

Pose ErrorPose(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to) {
  return edge.T_from_to.inverse() * (T_map_from.inverse() * T_map_to);
}

}  // namespace

EdgeTerms<6> LogMapTerms(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to) {
  EdgeTerms<6> out;
  out.error = core::Log(ErrorPose(edge, T_map_from, T_map_to));
  out.by_to = core::RightJacobianInverse(out.error);
  out.by_from = ByFrom(out.by_to, T_map_from, T_map_to);
  return out;
}

EdgeTerms<6> G2oTerms(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to, bool planar) {
  const Pose E = ErrorPose(edge, T_map_from, T_map_to);
  Eigen::Quaterniond q(E.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  EdgeTerms<6> out;
  out.error << E.translation(), q.vec();
  out.by_to.setZero();
  out.by_to.topLeftCorner<3, 3>() = E.linear();
  out.by_to.bottomRightCorner<3, 3>() = 0.5 * (q.w() * Mat3::Identity() + core::Skew(q.vec()));
  if (planar) {
    out.error[5] = core::YawOf(E.linear());
    out.by_to(5, 5) = 1.0;
  }
  out.by_from = ByFrom(out.by_to, T_map_from, T_map_to);
  return out;
}

EdgeTerms<12> ChordalTerms(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to,
                           const ChordalWeights& weights) {
  const double by_angle = std::sqrt(weights.kappa), by_length = std::sqrt(weights.tau);
  const Mat3 R_from = T_map_from.linear(), R_to = T_map_to.linear(), R = edge.T_from_to.linear();
  const Vec3 t = edge.T_from_to.translation();
  EdgeTerms<12> out;
  out.by_from.setZero();
  out.by_to.setZero();
  for (int k = 0; k < 3; ++k) {
    out.error.segment<3>(3 * k) = by_angle * (R_to.col(k) - R_from * R.col(k));
    out.by_from.block<3, 3>(3 * k, 3) = by_angle * R_from * core::Skew(R.col(k));
    out.by_to.block<3, 3>(3 * k, 3) = -by_angle * R_to * core::Skew(Vec3::Unit(k));
  }
  out.error.tail<3>() = by_length * (T_map_to.translation() - T_map_from * t);
  out.by_from.bottomLeftCorner<3, 3>() = -by_length * R_from;
  out.by_from.bottomRightCorner<3, 3>() = by_length * R_from * core::Skew(t);
  out.by_to.bottomLeftCorner<3, 3>() = by_length * R_to;
  return out;
}

}  // namespace atlas::mapping
