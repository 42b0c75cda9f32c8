#include "mapping/slam/lidar_front_end.h"

#include "core/se3.h"

namespace atlas::mapping {

using core::Mat6;
using core::Pose;

void LidarOdometryParams::Visit(core::ParamVisitor& v) {
  v.Field("voxel_m", &voxel_m,
          {.unit = "m",
           .min = 0.0,
           .max = 2.0,
           .doc = "of the local map that scans are matched to; 0: by the first scan's range, 0.2 to 0.6"});
  v.Field("map_radius_m", &map_radius_m,
          {.unit = "m", .min = 5.0, .max = 500.0, .doc = "of the local map about the LiDAR"});
  v.Field("prior_sigma_m", &prior_sigma_m,
          {.unit = "m",
           .min = 1e-4,
           .max = 10.0,
           .doc = "error of the prior's motion from scan to scan (standard deviation, an axis)"});
  v.Field("prior_sigma_rad", &prior_sigma_rad,
          {.unit = "rad", .min = 1e-5, .max = 1.0, .doc = "likewise of its rotation"});
  v.Field("min_eigenvalue", &min_eigenvalue,
          {.min = 0.0,
           .max = 0.3,
           .doc = "of the scatter of matched normals: below it, along a bare corridor, the prior is kept"});
  v.Field("min_overlap", &min_overlap,
          {.min = 0.0, .max = 1.0, .doc = "share of a scan that the map must hold, else the prior is kept"});
  v.Field("edge_floor_m", &edge_floor_m,
          {.unit = "m",
           .min = 1e-4,
           .max = 1.0,
           .doc = "least error of an edge after 2 m (standard deviation, an axis)"});
  v.Field("edge_floor_deg", &edge_floor_deg,
          {.unit = "deg", .min = 1e-3, .max = 10.0, .doc = "likewise of its rotation"});
}

void MotionCovariance::Add(const Pose& T_before_now, const Mat6& information) {
  const Mat6 A = core::Adjoint(T_before_now.inverse());
  covariance_lidar_ = A * covariance_lidar_ * A.transpose();
  const Eigen::LDLT<Mat6> factor(information);
  if (factor.info() == Eigen::Success && factor.isPositive() && factor.vectorD().minCoeff() > 0.0)
    covariance_lidar_ += factor.solve(Mat6::Identity());
}

Mat6 MotionCovariance::Take(const Pose& T_base_lidar, double way_m, double floor_m, double floor_deg) {
  constexpr double kEdgeM = 2.0;
  const Mat6 A = core::Adjoint(T_base_lidar);
  Mat6 covariance = A * covariance_lidar_ * A.transpose();
  const double share = std::max(0.1, way_m / kEdgeM), floor_rad = core::Radians(floor_deg);
  covariance.diagonal().head<3>().array() += share * floor_m * floor_m;
  covariance.diagonal().tail<3>().array() += share * floor_rad * floor_rad;
  covariance_lidar_.setZero();
  return 0.5 * (covariance + covariance.transpose());
}

namespace {

class LidarFrontEnd final : public Localiser {
 public:
  LidarFrontEnd(const LocalisationParams& params, const LocaliserStart& start, const core::Rng& rng)
      : params_(params.lidar_odometry), odometry_(params.lidar_odometry) {
    state_.T_odom_base = start.T_odom_base;
    LocaliserStart behind = start;
    behind.edge_covariance = [this](double way_m) {
      return motion_.Take(T_base_lidar_, way_m, params_.edge_floor_m, params_.edge_floor_deg);
    };
    localiser_ = MakeLocaliser(params, behind, rng);
  }

  void OnState(const core::StateEvent& state) override {
    state_ = state;
    localiser_->OnState(Corrected(state));
  }

  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    const LidarOdometryResult found = odometry_.Add(*spin);
    if (health_.revolutions++ > 0) {
      motion_.Add(T_odom_lidar_.inverse() * found.T_odom_lidar, found.information);
      health_.lost += !found.tracked;
      health_.degenerate += found.tracked && found.degenerate;
    }
    T_odom_lidar_ = found.T_odom_lidar;
    T_odom_prior_ = found.T_odom_prior;
    T_base_lidar_ = state_.T_odom_base.inverse() * spin->T_odom_lidar.At(found.time_s);
    localiser_->OnState(Corrected(state_));
    auto corrected = std::make_shared<core::SpinEvent>(*spin);
    corrected->T_odom_lidar = {};
    for (const core::StampedPose& pose : spin->T_odom_lidar.poses())
      corrected->T_odom_lidar.Add(pose.time_s, T_odom_prior_ * pose.T);
    core::AnchoredSpin placed = localiser_->Place(std::move(corrected));
    return {std::move(spin), placed.keyframe, placed.T_keyframe_odom * T_odom_prior_};
  }

  Pose T_map_odom() const override { return localiser_->T_map_odom() * T_odom_prior_; }
  std::shared_ptr<const core::PoseSource> poses() const override { return localiser_->poses(); }
  void Settle() override { localiser_->Settle(); }
  bool located() const override { return localiser_->located(); }
  std::shared_ptr<const SlamMemory> Memory() const override { return localiser_->Memory(); }
  std::optional<PoseGraph> InlierGraph() const override { return localiser_->InlierGraph(); }
  std::optional<OdometryHealth> odometry_health() const override { return health_; }

 private:
  core::StateEvent Corrected(core::StateEvent state) const {
    state.T_odom_base = T_odom_prior_ * state.T_odom_base;
    for (core::Vec3& foot : state.foot_odom) foot = T_odom_prior_ * foot;
    return state;
  }

  LidarOdometryParams params_;
  LidarOdometry odometry_;
  std::unique_ptr<Localiser> localiser_;
  core::StateEvent state_;  ///< the latest, in the prior's frame
  Pose T_odom_prior_ = Pose::Identity(), T_odom_lidar_ = Pose::Identity(), T_base_lidar_ = Pose::Identity();
  MotionCovariance motion_;
  OdometryHealth health_;
};

}  // namespace

std::unique_ptr<Localiser> PutLidarOdometryBefore(const LocalisationParams& params,
                                                  const LocaliserStart& start, const core::Rng& rng) {
  return std::make_unique<LidarFrontEnd>(params, start, rng);
}

}  // namespace atlas::mapping
