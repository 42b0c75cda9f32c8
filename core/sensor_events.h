// What the robot senses, as time-ordered events. A simulator emits them while it walks as well as while it
// sweeps; a recorded log replays the same ones.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry.h"

namespace atlas::core {

enum class ReturnKind : uint8_t {
  kHit,      ///< a surface at range_m
  kVoid,     ///< the beam left and met nothing within the sensor's range: evidence of free space
  kDropout,  ///< no information (lost return, or the robot's own body)
};

struct StampedPose {
  double time_s = 0.0;
  Pose T = Pose::Identity();
};

/// Poses by ascending time, interpolated between.
class PoseTrajectory {
 public:
  /// @pre time_s is not before the last pose's.
  void Add(double time_s, const Pose& T) { poses_.push_back({time_s, T}); }
  /// The pose at `time_s`, clamped to the first and the last. @pre not empty.
  Pose At(double time_s) const;
  const std::vector<StampedPose>& poses() const { return poses_; }
  bool empty() const { return poses_.empty(); }

 private:
  std::vector<StampedPose> poses_;
};

/// One revolution. Organised: ray i = row * columns + column. Unorganised (recorded clouds without a grid):
/// rows = 0 and `columns` rays in any order, each with its own direction.
struct LidarScan {
  double stamp_s = 0.0;  ///< start of the revolution
  int rows = 0;
  int columns = 0;
  std::vector<Vec3f> direction_lidar;  ///< unit, in the LiDAR frame at the ray's own time
  std::vector<float> range_m;          ///< metres; 0 unless kHit
  std::vector<float> time_s;           ///< after stamp_s
  std::vector<ReturnKind> kind;
  float min_range_m = 0.0f;
  float max_range_m = 0.0f;

  size_t size() const { return kind.size(); }
  bool organised() const { return rows > 0; }
};

/// A revolution and where the odometry says that the LiDAR was while it lasted.
struct SpinEvent {
  LidarScan scan;
  PoseTrajectory T_odom_lidar;
  /// Part of a scanning action (thesis 3.3, 3.6.1): one roll from + to - and back.
  bool scanning = false;
};

/// Depth along the optical axis, row-major, top row first; pixel centres at (u + 0.5, v + 0.5).
struct DepthImage {
  int width = 0;
  int height = 0;
  double focal_px = 0.0;       ///< fx = fy; principal point at the centre
  std::vector<float> depth_m;  ///< NaN = no measurement
};

/// The camera frame is x right, y down, z forward.
struct DepthEvent {
  double time_s = 0.0;
  DepthImage image;
  Pose T_odom_camera = Pose::Identity();
};

struct StateEvent {
  double time_s = 0.0;
  Pose T_odom_base = Pose::Identity();                                           ///< proprioceptive odometry
  Vec3 foot_odom[4] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< sole points; LF RF LH RH
  bool foot_in_contact[4] = {false, false, false, false};
};

/// Receives events in time order. A sink that wants only some overrides those.
class SensorSink {
 public:
  virtual ~SensorSink() = default;
  virtual void OnState(const StateEvent&) {}
  virtual void OnSpin(const std::shared_ptr<const SpinEvent>&) {}
  virtual void OnDepth(const DepthEvent&) {}
};

}  // namespace atlas::core
