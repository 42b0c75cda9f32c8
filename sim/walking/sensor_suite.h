// Runs the robot's sensors on its motion and hands their events on in time order.
#pragma once

#include <optional>
#include <vector>

#include "sim/locomotion/locomotion.h"
#include "sim/sensors/depth_camera.h"
#include "sim/sensors/lidar.h"
#include "sim/walking/odometry.h"

namespace atlas::sim {

enum class Activity { kStanding, kWalking, kSweeping };

class SensorSuite {
 public:
  SensorSuite(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const SensorParams& params,
              const Locomotion& carrier, const core::Rng& rng);

  /// Decides which revolutions are cast from their start on, and whether the depth camera runs.
  void SetActivity(Activity activity) { activity_ = activity; }
  /// Call at every step between BeginStep and FinishStep. Events go to `sink`, which may be null.
  void Observe(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink);

  std::string render_backend() const { return camera_ ? camera_->backend() : "off"; }
  std::string render_problem() const { return camera_ ? camera_->why_unavailable() : ""; }

  double revolution_s() const { return 1.0 / lidar_.model().spin_rate_hz; }
  /// Whether a revolution starts at the next observation.
  bool AtSpinStart(double time_s) const;

 private:
  struct BodyPoses {
    double time_s;
    std::vector<core::Pose> T_map_body;
  };

  void StartSpin(double time_s);
  void RecordSpin(const Locomotion& robot, const Odometry& odometry);
  void FinishSpin(core::SensorSink* sink);
  void PoseBodies(double time_s);
  void TakeDepth(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink);
  void EmitState(const Locomotion& robot, const Odometry& odometry, core::SensorSink* sink);

  SensorParams params_;
  core::Pose T_base_lidar_, T_base_camera_;
  Raycaster raycaster_;
  Lidar lidar_;
  std::optional<DepthCamera> camera_;
  Activity activity_ = Activity::kStanding;

  int64_t spin_ = -1;  ///< revolutions since the start
  int64_t idle_spins_ = 0;
  bool casting_ = false;
  Activity spin_activity_ = Activity::kStanding;  ///< when this revolution started
  double spin_start_s_ = 0.0;
  core::PoseTrajectory T_map_lidar_, T_odom_lidar_;
  std::vector<BodyPoses> bodies_;
  int64_t states_ = 0;
  double next_depth_s_ = 0.0;
  std::vector<core::Pose> T_map_body_;  ///< scratch
};

}  // namespace atlas::sim
