#include "sim/walking/odometry.h"

namespace atlas::sim {
namespace {

constexpr double kDriftStepM = 0.01;  ///< the walk draws once a centimetre

// `drift` at scale 1: standard deviations an axis after an edge of a pose graph.
constexpr double kEdgeM = 2.0, kEdgeSigmaM = 0.02, kEdgeSigmaDeg = 0.1;

core::Vec3 NormalVector(core::Rng* rng) {
  const double x = rng->Normal(), y = rng->Normal(), z = rng->Normal();
  return {x, y, z};
}

}  // namespace

Odometry::Odometry(const OdometryParams& params, const core::Pose& T_map_spawn, const core::Pose& T_map_base,
                   const core::Rng& rng)
    : params_(params),
      drift_rng_(rng.Split("odometry_drift")),
      T_odom_map_(T_map_spawn.inverse()),
      T_odom_base_(T_odom_map_ * T_map_base),
      p_last_(T_map_base.translation().head<2>()) {
  if (params.name != "drift" || params.drift_bias == 0.0) return;
  core::Rng bias_rng = rng.Split("odometry_bias");
  const double share = params.drift_bias * params.drift_scale / kEdgeM;
  bias_m_ = share * kEdgeSigmaM * NormalVector(&bias_rng);
  bias_rad_ = share * core::Radians(kEdgeSigmaDeg) * NormalVector(&bias_rng);
}

core::Pose Odometry::LegsError(const core::Pose& T_map_base, const core::Vec2& walked_map) {
  const bool prior = params_.name == "lidar";
  const double sigma_deg = prior ? params_.prior_yaw_deg_per_m : params_.drift_yaw_deg_per_m;
  const double sigma_m = prior ? params_.prior_xy_per_m : params_.drift_xy_per_m;
  const double walked_m = walked_map.norm(), share = std::sqrt(walked_m);
  double yaw = share * core::Radians(sigma_deg) * drift_rng_.Normal();
  const double x = share * sigma_m * drift_rng_.Normal();
  const double y = share * sigma_m * drift_rng_.Normal();
  core::Vec3 away(x, y, 0.0);
  if (prior) {
    yaw += walked_m * core::Radians(params_.prior_bias_deg_per_m);
    away += params_.prior_bias * (T_odom_map_.linear() * core::Vec3(walked_map.x(), walked_map.y(), 0.0));
  }
  // The error happens where the robot is, so heading errors do not swing it about a distant origin.
  const core::Vec3 here = T_odom_map_ * T_map_base.translation();
  const core::Pose error = Eigen::Translation3d(here + away) * Eigen::AngleAxisd(yaw, core::Vec3::UnitZ()) *
                           Eigen::Translation3d(-here);
  return error * T_odom_map_;
}

core::Pose Odometry::WanderError(const core::Pose& T_map_base, double walked_m) {
  const double share = params_.drift_scale * std::sqrt(walked_m / kEdgeM);
  const core::Vec3 t = share * kEdgeSigmaM * NormalVector(&drift_rng_) + walked_m * bias_m_;
  const core::Vec3 r =
      share * core::Radians(kEdgeSigmaDeg) * NormalVector(&drift_rng_) + walked_m * bias_rad_;
  core::Mat3 R = core::Mat3::Identity();
  if (r.norm() > 0.0) R = Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix();
  return T_odom_map_ * T_map_base * core::MakePose(R, t) * T_map_base.inverse();
}

void Odometry::Update(const core::Pose& T_map_base) {
  const core::Vec2 p = T_map_base.translation().head<2>();
  const core::Vec2 walked = p - p_last_;
  if (walked.norm() >= kDriftStepM && params_.name != "truth") {
    p_last_ = p;
    T_odom_map_ =
        params_.name == "drift" ? WanderError(T_map_base, walked.norm()) : LegsError(T_map_base, walked);
  }
  T_odom_base_ = T_odom_map_ * T_map_base;
}

}  // namespace atlas::sim
