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
  struct Opening {
    double width_m;
    core::Vec2 middle;
  };
  /// The opening around a place; none where it is wider than `widest_m`.
  std::optional<Opening> OpeningAt(const core::Vec2& p, double widest_m) const;

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
  /// The sensor went on to a place. @returns whether it has just passed the middle of a doorway.
  bool Move(const core::Vec3& p_odom_sensor);
  /// Whether it is in a narrow stretch.
  bool InNarrow() const { return narrow_.has_value(); }

 private:
  /// A narrow stretch that the sensor is in.
  struct Narrow {
    core::Vec2 begin;              ///< where it began
    core::Vec2 middle, direction;  ///< of the opening as seen from there; of the way
    double way_m = 0.0;
    bool beyond = false;  ///< the sensor is on the far side
  };
  bool Step(const core::Vec2& p, const core::Vec2& direction, double step_m);
  /// Whether the way, if it goes straight on, comes into the open soon.
  bool OpensAhead(const core::Vec2& p, const core::Vec2& direction) const;

  double widest_m_;
  std::vector<core::Vec3f> before_;
  Uprights uprights_;
  std::optional<core::Vec2> last_;
  std::optional<Narrow> narrow_;
  /// The doorway passed last, and the way since.
  std::optional<core::Vec2> passed_at_;
  double since_m_ = 0.0;
};

}  // namespace atlas::mapping
