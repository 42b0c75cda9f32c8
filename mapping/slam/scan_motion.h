// How the LiDAR moved while a revolution lasted: a prior's motion, corrected at its start and at its end, and
// between them in proportion to time (Dellenbach et al., CT-ICP, 2022).
#pragma once

#include <vector>

#include "core/se3.h"
#include "core/sensor_events.h"

namespace atlas::mapping {

/// Right perturbations of the predicted poses: [at the start; at the end].
using ScanCorrection = Eigen::Matrix<double, 12, 1>;

class ScanMotion {
 public:
  static constexpr size_t kSlices = 256;  ///< of a revolution, each with one pose
  using SlicePoses = std::vector<core::Pose>;

  /// @param scan, T_prior_lidar outlive it.
  /// @param T_odom_prior  where the prior's frame is at the start
  ScanMotion(const core::LidarScan& scan, const core::PoseTrajectory& T_prior_lidar,
             const core::Pose& T_odom_prior);

  double start_s() const { return start_s_; }
  double end_s() const { return start_s_ + duration_s_; }
  /// 0 at the start to 1 at the end; 1 where all rays are of one time.
  double ShareAt(double time_s) const;
  double ShareOf(size_t slice) const { return ShareAt(TimeOf(slice)); }
  core::Pose Predicted(double time_s) const { return T_odom_prior_ * T_prior_lidar_.At(time_s); }
  core::Pose Corrected(double time_s, const ScanCorrection& correction) const;
  /// T_odom_lidar at the start, at the prior's times and at the end.
  core::PoseTrajectory Trajectory(const ScanCorrection& correction) const;

  /// Returns in the frame of the LiDAR at the end, and the slice that each was measured in.
  struct Returns {
    std::vector<core::Vec3f> p_end;
    std::vector<uint8_t> slice;
    SlicePoses T_slice_end;  ///< takes points back into the frame of the LiDAR in their slice
  };
  Returns Undistorted(const ScanCorrection& correction, double max_range_m) const;
  /// T_odom_lidar of each slice.
  SlicePoses PosesOf(const ScanCorrection& correction) const;

 private:
  double TimeOf(size_t slice) const;
  core::Pose Corrected(const core::Pose& predicted, double share, const ScanCorrection& correction) const;

  const core::LidarScan& scan_;
  const core::PoseTrajectory& T_prior_lidar_;
  core::Pose T_odom_prior_;
  double start_s_ = 0.0, duration_s_ = 0.0;
  SlicePoses predicted_;  ///< of each slice
};

}  // namespace atlas::mapping
