// What planning asks of the terrain: where the robot may stand, and how hard the ground is.
#pragma once

#include "core/geometry.h"

namespace atlas::planner {

/// Implemented by the perceived elevation map; a test may stand in for it. Frame: map.
class TraversableGround {
 public:
  virtual ~TraversableGround() = default;

  /// Mean height, slope (radians) and roughness (metres) under the footprint.
  struct Surface {
    double height_m = 0.0, slope_rad = 0.0, roughness_m = 0.0;
  };

  /// Traversability of the cell in [0, 1] (1 = flat, solid); 0 where unknown, an edge, or blocked.
  virtual double Traversability(const core::Vec2& p_map) const = 0;
  /// Whether the robot's footprint at this pose rests wholly on traversable cells with headroom.
  virtual bool FootprintFree(const core::Vec2& p_map, double yaw_rad) const = 0;
  /// As above for any heading (circle of the footprint's radius).
  virtual bool CircleFree(const core::Vec2& p_map) const = 0;
  virtual Surface SurfaceAt(const core::Vec2& p_map) const = 0;
  /// Square that planning may use: centred on the robot, side window_m.
  virtual core::Box3 Window() const = 0;
};

}  // namespace atlas::planner
