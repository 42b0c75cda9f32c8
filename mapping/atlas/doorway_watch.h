// Doorways on the way of a sensor: where free space is narrow for a short stretch, between upright edges.
//
//      room       │  │         width: from the nearest edge a to the nearest one b that lies on the
//         ·  ·  · a  │         other side of the way (seen from the way, a and b are more than 120
//     ── way ────────── >      degrees apart). Beside one wall, or in a corner, there is no such b;
//         ·  ·  · b  │         in the open it is far away.
//                 │  │  corridor
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// Uprights near the height of a sensor, in columns of a grid: how wide is the opening around a place?
class Uprights {
 public:
  /// Adds returns between 0.2 m below and 0.7 m above `height_m` (over tables, under lintels).
  void Add(std::span<const core::Vec3f> points, double height_m);
  /// The width of the opening around a place, m; infinity where it is above `widest_m`.
  double WidthAt(const core::Vec2& p, double widest_m) const;

 private:
  struct Column {
    core::Vec2 sum = core::Vec2::Zero();
    int points = 0;
  };
  std::unordered_map<uint64_t, Column> columns_;
};

class DoorwayWatch {
 public:
  /// @param widest_m  of a doorway; 0: there is none.
  explicit DoorwayWatch(double widest_m) : widest_m_(widest_m) {}

  /// What was seen from a keyframe, in the odometry's frame (z up); what was seen from the one before it is
  /// kept beside.
  void See(std::vector<core::Vec3f> points_odom, const core::Vec3& p_odom_sensor);
  /// The sensor went on to a place. @returns whether it has just left a doorway by the other side.
  bool Move(const core::Vec3& p_odom_sensor);

 private:
  struct Narrow {
    core::Vec2 from;
    double way_m;
  };
  double widest_m_;
  std::vector<core::Vec3f> before_;
  Uprights uprights_;
  std::optional<core::Vec2> last_;
  std::optional<Narrow> narrow_;  ///< that the sensor is in
};

}  // namespace atlas::mapping
