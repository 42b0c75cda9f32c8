// LiDAR odometry in front of a localiser (`odometry.name: lidar`).
//
//      map ──T_map_odom──> odom ──T_odom_prior──> prior ──T_prior_base──> base
//        (the localiser's)     (scan matching's)      (legs, IMU: smooth; states and revolutions come in it)
//
// The localiser hears states and revolutions as scan matching corrected them. To all others the prior's frame
// is the odometry's, so that nothing jumps under the feet.
#pragma once

#include <memory>

#include "mapping/slam/lidar_odometry.h"
#include "mapping/slam/localiser.h"

namespace atlas::mapping {

/// The covariance of the base's motion since it was last taken, by the information of each revolution; xi in
/// T Exp(xi), translation before rotation.
class MotionCovariance {
 public:
  /// @param information  of the LiDAR's motion `T_before_now`; zero: nothing is known to have moved
  void Add(const core::Pose& T_before_now, const core::Mat6& information);
  /// In the base's frame now, and begins anew. Not below what `floor_m` and `floor_deg` (an axis, after 2 m,
  /// growing with the root of the way) tell: matching against one map errs alike from scan to scan.
  core::Mat6 Take(const core::Pose& T_base_lidar, double way_m, double floor_m, double floor_deg);

 private:
  core::Mat6 covariance_lidar_ = core::Mat6::Zero();
};

/// The localiser of params.name behind LiDAR odometry. @throws InputError for an unknown name.
std::unique_ptr<Localiser> PutLidarOdometryBefore(const LocalisationParams& params,
                                                  const LocaliserStart& start, const core::Rng& rng);

}  // namespace atlas::mapping
