// Velocity commands that follow a polyline in the map frame from believed poses.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "sim/locomotion/trot_controller.h"

namespace atlas::sim {

class PathTracker {
 public:
  enum class Status { kWalking, kArrived, kStuck };

  /// `waypoints_map` may be empty (turn on the spot). The path starts where the robot is.
  PathTracker(std::vector<core::Vec2> waypoints_map, double final_yaw_rad, double speed_mps);

  struct Output {
    Status status = Status::kWalking;
    VelocityCommand command;
  };
  /// Call every 20 ms or so with time ascending.
  Output Update(double time_s, const core::Vec2& p_map, double yaw_rad);

  double length_m() const { return arc_.empty() ? 0.0 : arc_.back(); }

 private:
  void Start(const core::Vec2& p_map);
  void Project(const core::Vec2& p_map);
  core::Vec2 PointAt(double arc_m) const;
  double SpeedLimit(double arc_m) const;
  VelocityCommand Follow(const core::Vec2& p_map, double yaw_rad);
  VelocityCommand Settle(const core::Vec2& p_map, double yaw_rad) const;
  bool Progressing(double time_s, double remaining);

  std::vector<core::Vec2> points_;
  double final_yaw_rad_, speed_mps_;
  std::vector<double> arc_;         ///< of each point
  std::vector<double> corner_mps_;  ///< speed allowed at each point
  bool started_ = false;
  bool turning_ = true;    ///< on the spot
  bool settling_ = false;  ///< at the end, holding position and turning to the final yaw
  double settling_since_s_ = 0.0;
  double along_m_ = 0.0;  ///< arc of the nearest point ahead of all before
  double best_remaining_ = 1e9;
  double progress_time_s_ = 0.0;
};

}  // namespace atlas::sim
