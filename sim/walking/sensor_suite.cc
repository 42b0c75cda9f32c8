#include "sim/walking/sensor_suite.h"

namespace atlas::sim {
namespace {

constexpr double kStateRateHz = 50.0;
constexpr double kPoseSpacingS = 0.004;
constexpr double kBodySpacingS = 0.01;
constexpr double kTimeEps = 1e-6;  ///< clocks add up steps

core::LidarModel ModelFor(const SensorParams& params, const robots::RobotSpec& robot) {
  core::LidarModel model = robots::LidarOf(robot, params.lidar);
  if (params.range_sigma_m >= 0.0) model.range_sigma_m = params.range_sigma_m;
  return model;
}

}  // namespace

SensorSuite::SensorSuite(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                         const SensorParams& params, const Locomotion& carrier, const core::Rng& rng)
    : params_(params),
      T_base_lidar_(robot.T_base_lidar),
      T_base_camera_(robot.T_base_depth),
      raycaster_(scene),
      lidar_(ModelFor(params, robot), rng.Split("lidar")) {
  if (params.depth_camera) {
    DepthCameraModel model;
    model.width = params.depth_width;
    model.height = params.depth_height;
    model.max_depth_m = params.depth_max_m;
    camera_.emplace(scene, model, rng.Split("depth"));
  }
  if (carrier.carried()) return;  // nothing of it is seen
  for (const core::TriMesh& mesh : carrier.world().body_meshes()) {
    raycaster_.AddBody(mesh);
    if (camera_) camera_->AddBody(mesh);
  }
}

bool SensorSuite::AtSpinStart(double time_s) const {
  const double next_s = static_cast<double>(spin_ + 1) / lidar_.model().spin_rate_hz;
  return time_s >= next_s - kTimeEps;
}

void SensorSuite::Observe(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink) {
  const double now = robot.time_s();
  if (now >= static_cast<double>(states_) / kStateRateHz - kTimeEps) {
    ++states_;
    if (sink != nullptr) EmitState(robot, odometry, sink);
  }
  const bool depth_due = activity_ == Activity::kWalking && now >= next_depth_s_ - kTimeEps;
  if (depth_due && camera_ && camera_->available() && sink != nullptr) TakeDepth(robot, odometry, sink);
  const bool turn_over = AtSpinStart(now);
  if (casting_) {
    RecordSpin(robot, odometry);
    if (turn_over) FinishSpin(sink);
  }
  if (turn_over) {
    StartSpin(now);
    if (casting_) RecordSpin(robot, odometry);
  }
}

void SensorSuite::EmitState(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink) {
  core::StateEvent event;
  event.time_s = robot.time_s();
  event.T_odom_base = odometry.T_odom_base();
  const core::Pose T_odom_map = odometry.T_odom_base() * robot.T_map_base().inverse();
  for (int i = 0; i < kLegs; ++i) {
    const FootStatus foot = robot.foot(i);
    event.foot_odom[i] = T_odom_map * foot.p_sole;
    event.foot_in_contact[i] = foot.in_contact;
  }
  sink->OnState(event);
}

void SensorSuite::TakeDepth(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink) {
  next_depth_s_ = robot.time_s() + 1.0 / params_.depth_rate_hz;
  if (!robot.carried()) robot.world().BodyPoses(&T_map_body_);
  for (size_t i = 0; i < T_map_body_.size(); ++i) camera_->SetBodyPose(static_cast<int>(i), T_map_body_[i]);
  core::DepthEvent event;
  event.time_s = robot.time_s();
  event.image = camera_->Capture(robot.T_map_base() * T_base_camera_);
  event.T_odom_camera = odometry.T_odom_base() * T_base_camera_;
  sink->OnDepth(event);
}

void SensorSuite::StartSpin(double time_s) {
  ++spin_;
  spin_start_s_ = time_s;
  spin_activity_ = activity_;
  casting_ = activity_ == Activity::kSweeping || idle_spins_++ % params_.walking_spin_stride == 0;
  T_map_lidar_ = {};
  T_odom_lidar_ = {};
  bodies_.clear();
}

void SensorSuite::RecordSpin(const Locomotion& robot, const Odometry& odometry) {
  const double now = robot.time_s();
  const auto& poses = T_map_lidar_.poses();
  const bool last = AtSpinStart(now);
  if (poses.empty() || last || now >= poses.back().time_s + kPoseSpacingS - kTimeEps) {
    T_map_lidar_.Add(now, robot.T_map_base() * T_base_lidar_);
    T_odom_lidar_.Add(now, odometry.T_odom_base() * T_base_lidar_);
  }
  if (bodies_.empty() || now >= bodies_.back().time_s + kBodySpacingS - kTimeEps) {
    bodies_.push_back({now, {}});
    if (!robot.carried()) robot.world().BodyPoses(&bodies_.back().T_map_body);
  }
}

void SensorSuite::PoseBodies(double time_s) {
  const BodyPoses* nearest = &bodies_.front();
  for (const BodyPoses& poses : bodies_) {
    if (std::abs(poses.time_s - time_s) < std::abs(nearest->time_s - time_s)) nearest = &poses;
  }
  for (size_t i = 0; i < nearest->T_map_body.size(); ++i) {
    raycaster_.SetBodyPose(static_cast<int>(i), nearest->T_map_body[i]);
  }
}

void SensorSuite::FinishSpin(core::SensorSink* sink) {
  if (sink == nullptr) return;
  const auto event = std::make_shared<core::SpinEvent>();
  event->scan = lidar_.Spin(
      &raycaster_, spin_start_s_, T_map_lidar_, [this](double t) { PoseBodies(t); }, params_.threads);
  event->T_odom_lidar = std::move(T_odom_lidar_);
  event->scanning = spin_activity_ == Activity::kSweeping;
  sink->OnSpin(event);
}

}  // namespace atlas::sim
