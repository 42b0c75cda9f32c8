#include "mapping/slam/scan_motion.h"

#include <algorithm>
#include <array>

namespace atlas::mapping {

using core::Pose;
using core::PoseTrajectory;

ScanMotion::ScanMotion(const core::LidarScan& scan, const PoseTrajectory& T_prior_lidar,
                       const Pose& T_odom_prior)
    : scan_(scan), T_prior_lidar_(T_prior_lidar), T_odom_prior_(T_odom_prior), start_s_(scan.stamp_s) {
  const auto [first, last] = std::minmax_element(scan.time_s.begin(), scan.time_s.end());
  if (first != scan.time_s.end()) {
    start_s_ += static_cast<double>(*first);
    duration_s_ = static_cast<double>(*last) - static_cast<double>(*first);
  }
  for (size_t k = 0; k < kSlices && !T_prior_lidar.empty(); ++k) predicted_.push_back(Predicted(TimeOf(k)));
}

double ScanMotion::ShareAt(double time_s) const {
  return duration_s_ > 0.0 ? std::clamp((time_s - start_s_) / duration_s_, 0.0, 1.0) : 1.0;
}

double ScanMotion::TimeOf(size_t slice) const {
  return start_s_ + duration_s_ * (static_cast<double>(slice) + 0.5) / kSlices;
}

Pose ScanMotion::Corrected(const Pose& predicted, double share, const ScanCorrection& correction) const {
  return predicted * core::Exp((1.0 - share) * correction.head<6>() + share * correction.tail<6>());
}

Pose ScanMotion::Corrected(double time_s, const ScanCorrection& correction) const {
  return Corrected(Predicted(time_s), ShareAt(time_s), correction);
}

ScanMotion::SlicePoses ScanMotion::PosesOf(const ScanCorrection& correction) const {
  SlicePoses poses;
  for (size_t k = 0; k < predicted_.size(); ++k)
    poses.push_back(Corrected(predicted_[k], ShareOf(k), correction));
  return poses;
}

PoseTrajectory ScanMotion::Trajectory(const ScanCorrection& correction) const {
  PoseTrajectory trajectory;
  if (end_s() > start_s()) trajectory.Add(start_s(), Corrected(start_s(), correction));
  for (const core::StampedPose& pose : T_prior_lidar_.poses()) {
    if (pose.time_s > start_s() && pose.time_s < end_s())
      trajectory.Add(pose.time_s, Corrected(pose.time_s, correction));
  }
  trajectory.Add(end_s(), Corrected(end_s(), correction));
  return trajectory;
}

ScanMotion::Returns ScanMotion::Undistorted(const ScanCorrection& correction, double max_range_m) const {
  const Pose T_odom_end = Corrected(end_s(), correction);
  Returns returns;
  std::array<Eigen::Isometry3f, kSlices> T_end_slice;
  for (const Pose& T_odom_slice : PosesOf(correction)) {
    T_end_slice[returns.T_slice_end.size()] = (T_odom_end.inverse() * T_odom_slice).cast<float>();
    returns.T_slice_end.push_back(T_odom_slice.inverse() * T_odom_end);
  }
  const float to_slice = duration_s_ > 0.0 ? static_cast<float>(kSlices / duration_s_) : 0.0f;
  const auto first_s = static_cast<float>(start_s_ - scan_.stamp_s);
  for (size_t i = 0; i < scan_.size(); ++i) {
    if (scan_.kind[i] != core::ReturnKind::kHit || static_cast<double>(scan_.range_m[i]) > max_range_m)
      continue;
    const auto slice =
        std::min(kSlices - 1, static_cast<size_t>(std::max(0.0f, (scan_.time_s[i] - first_s) * to_slice)));
    returns.p_end.push_back(T_end_slice[slice] * (scan_.range_m[i] * scan_.direction_lidar[i]));
    returns.slice.push_back(static_cast<uint8_t>(slice));
  }
  return returns;
}

}  // namespace atlas::mapping
