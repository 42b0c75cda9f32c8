#include "sim/walking/odometry.h"

namespace atlas::sim {
namespace {

constexpr double kDriftStepM = 0.01;  ///< the walk draws once a centimetre

}  // namespace

Odometry::Odometry(const OdometryParams& params, const core::Pose& T_map_spawn, const core::Pose& T_map_base,
                   const core::Rng& rng)
    : params_(params),
      drift_rng_(rng.Split("odometry_drift")),
      T_odom_map_(T_map_spawn.inverse()),
      T_odom_base_(T_odom_map_ * T_map_base),
      p_last_(T_map_base.translation().head<2>()) {}

void Odometry::Update(const core::Pose& T_map_base) {
  const core::Vec2 p = T_map_base.translation().head<2>();
  const double walked_m = (p - p_last_).norm();
  if (walked_m >= kDriftStepM) {
    p_last_ = p;
    const double share = std::sqrt(walked_m);
    const double yaw = share * core::Radians(params_.drift_yaw_deg_per_m) * drift_rng_.Normal();
    const double x = share * params_.drift_xy_per_m * drift_rng_.Normal();
    const double y = share * params_.drift_xy_per_m * drift_rng_.Normal();
    // The error happens where the robot is, so heading errors do not swing it about a distant origin.
    const core::Vec3 here = T_odom_map_ * T_map_base.translation();
    const core::Pose error = Eigen::Translation3d(here + core::Vec3(x, y, 0.0)) *
                             Eigen::AngleAxisd(yaw, core::Vec3::UnitZ()) * Eigen::Translation3d(-here);
    T_odom_map_ = error * T_odom_map_;
  }
  T_odom_base_ = T_odom_map_ * T_map_base;
}

}  // namespace atlas::sim
