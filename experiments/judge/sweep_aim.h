// From which roll of which heading a scanning sweep puts a beam on a point.
//
// The base stands level at a position and rolls about its nose axis. Of the evenly spaced headings, the one
// that has the point most nearly on its left sees it with the widest elevation range; mirrored headings add
// nothing, since a sweep rolls both ways.
#pragma once

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "robots/robot_spec.h"

namespace atlas::experiments {

class SweepAim {
 public:
  /// @pre headings >= 1
  SweepAim(const robots::RobotSpec& robot, const core::LidarModel& lidar, int headings, double max_roll_rad);

  /// A ray from the sensor to a point.
  struct Shot {
    core::Vec3f origin;
    core::Vec3f direction;  ///< unit
    float distance_m;
  };
  /// Aims from the base over `ground_map` (a point on the ground). `variant` 0 rolls to bring the point to
  /// the middle of the beams, 1 and 2 to near their lower and upper ends, so that the sensor stands
  /// elsewhere. False where no roll of that heading puts a beam there.
  bool At(const core::Vec3& ground_map, const core::Vec3f& target_map, int variant, Shot* shot) const;

  /// Height of the level sensor above the ground, and how far a roll may carry it from there.
  double sensor_height_m() const { return sensor_height_m_; }
  double sensor_reach_m() const { return sensor_reach_m_; }
  /// Rays per steradian that the sweeps of all headings send, averaged over the directions they see.
  double RaysPerSteradian(const core::LidarModel& lidar, int headings, double period_s) const;

 private:
  core::Pose T_base_lidar_;
  double stance_m_, sensor_height_m_, sensor_reach_m_;
  double heading_step_rad_, max_roll_rad_;
  double lowest_rad_, highest_rad_;  // beam elevations
};

}  // namespace atlas::experiments
