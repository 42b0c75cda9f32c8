// What planning asks of the terrain: where the robot may stand, and how hard the ground is.
#pragma once

#include <cstdint>

#include "core/geometry.h"

namespace atlas::mapping {

/// Why a cell of the ground does or does not carry the robot.
enum class GroundKind : uint8_t {
  kUnknown,    ///< nothing seen, or no support and no sign of a drop
  kFree,       ///< carries the robot
  kObstacle,   ///< something at the body's height
  kStep,       ///< relief beyond the step limit, or a ridge that feet trip over
  kSlope,      ///< steeper than the limit
  kRoughness,  ///< rougher than the limit
  kDrop,       ///< a hole, an edge, or its rim
  kOverhang,   ///< the body's space above was not seen to be empty
  kCutOff,     ///< passable, but no passable way joins it to the robot
};

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
  /// kFree exactly where the cell does not block the footprint.
  virtual GroundKind KindAt(const core::Vec2& p_map) const = 0;
  /// Whether the robot's footprint at this pose rests wholly on traversable cells with headroom.
  virtual bool FootprintFree(const core::Vec2& p_map, double yaw_rad) const = 0;
  /// As above for any heading (circle of the footprint's radius).
  virtual bool CircleFree(const core::Vec2& p_map) const = 0;
  virtual Surface SurfaceAt(const core::Vec2& p_map) const = 0;
  /// Square that planning may use: centred on the robot, side window_m.
  virtual core::Box3 Window() const = 0;
};

}  // namespace atlas::mapping
