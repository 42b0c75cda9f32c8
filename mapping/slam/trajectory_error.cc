#include "mapping/slam/trajectory_error.h"

#include <cassert>
#include <cmath>

namespace atlas::mapping {
namespace {

core::Vec3 MeanPosition(const std::vector<core::Pose>& poses) {
  core::Vec3 sum = core::Vec3::Zero();
  for (const core::Pose& T : poses) sum += T.translation();
  return sum / static_cast<double>(poses.size());
}

}  // namespace

core::Pose AlignTrajectory(const std::vector<core::Pose>& estimate, const std::vector<core::Pose>& truth) {
  assert(estimate.size() == truth.size() && !truth.empty());
  // Arun et al., PAMI 1987: the rotation from the SVD of the covariance of the two sets.
  const core::Vec3 from = MeanPosition(estimate), to = MeanPosition(truth);
  core::Mat3 covariance = core::Mat3::Zero();
  for (size_t k = 0; k < truth.size(); ++k)
    covariance += (truth[k].translation() - to) * (estimate[k].translation() - from).transpose();
  const Eigen::JacobiSVD<core::Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  core::Vec3 sign = core::Vec3::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign.z() = -1.0;
  const core::Mat3 R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  return core::MakePose(R, to - R * from);
}

double AbsoluteTrajectoryError(const std::vector<core::Pose>& estimate,
                               const std::vector<core::Pose>& truth) {
  const core::Pose T_truth_map = AlignTrajectory(estimate, truth);
  double sum = 0.0;
  for (size_t k = 0; k < truth.size(); ++k)
    sum += (T_truth_map * estimate[k].translation() - truth[k].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

}  // namespace atlas::mapping
