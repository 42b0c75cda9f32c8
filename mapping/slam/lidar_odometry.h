// LiDAR odometry: each revolution, undistorted by a prior, is matched to a local map of the last ones.
//
//        odom ──T_odom_prior──> prior ──T_prior_lidar(t)──> lidar
//          (corrected by each scan)   (legs, IMU, or the last motion continued)
#pragma once

#include <memory>
#include <optional>

#include "core/geometry.h"
#include "core/params.h"
#include "core/sensor_events.h"
#include "mapping/cloud/registration.h"

namespace atlas::mapping {

struct LidarOdometryParams {
  double voxel_m = 0.0;  ///< of the local map; 0: a fifteenth of the first scan's median range, 0.2 to 0.6 m
  double map_radius_m = 60.0;    ///< of the local map about the LiDAR
  double max_range_m = 80.0;     ///< returns beyond are left out
  size_t matched_points = 2000;  ///< of a scan, at most: spread evenly
  int max_iterations = 25;
  double converged_m = 5e-4;
  double converged_rad = 2e-4;
  /// Standard deviations of a prior's motion over one revolution.
  double prior_sigma_m = 0.05;
  double prior_sigma_rad = 0.01;
  /// Without a prior: of the acceleration that changes the last motion.
  double acceleration_m_s2 = 10.0;
  double acceleration_rad_s2 = 10.0;
  /// Of the scatter of matched normals (registration.h): along eigenvectors below it the prior is kept.
  double min_eigenvalue = 0.02;
  /// Below it the scan is matched to the last one from farther away (Register), and is lost if that fails.
  double min_overlap = 0.4;
  /// As an edge of a pose graph: least standard deviations after 2 m, growing with the root of the way.
  double edge_floor_m = 0.005;
  double edge_floor_deg = 0.05;
  int threads = 1;  ///< results do not depend on it
  void Visit(core::ParamVisitor& v);
};

struct LidarOdometryResult {
  double time_s = 0.0;                               ///< the revolution's end
  core::Pose T_odom_lidar = core::Pose::Identity();  ///< then
  core::Pose T_odom_prior = core::Pose::Identity();  ///< for poses of the prior after it
  core::PoseTrajectory trajectory;  ///< T_odom_lidar over the revolution, at the prior's times
  /// Inverse covariance of the motion since the last revolution, of xi in T Exp(xi), translation before
  /// rotation. Zero where there was none.
  Matrix6 information = Matrix6::Zero();
  bool tracked = false;     ///< matched to the map; else the prior alone
  bool degenerate = false;  ///< some direction kept the prior
  double min_eigenvalue = 0.0;
  core::Vec3 weak_direction_odom = core::Vec3::Zero();
  double overlap = 0.0;  ///< share of the points with a partner in the map
  double rmse_m = 0.0;   ///< of their distances
};

class LidarOdometry {
 public:
  explicit LidarOdometry(const LidarOdometryParams& params);
  ~LidarOdometry();

  /// @param spin its T_odom_lidar is the prior's T_prior_lidar. Call in time order.
  LidarOdometryResult Add(const core::SpinEvent& spin);
  /// Without any prior: the motion of the last revolution goes on, and a change of it is found from the scan
  /// itself, at its start and at its end.
  LidarOdometryResult Add(const core::LidarScan& scan);
  /// With a gyroscope's R_prior_lidar while the revolution lasted (positions are not read).
  LidarOdometryResult Add(const core::LidarScan& scan, const core::PoseTrajectory& attitude);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
