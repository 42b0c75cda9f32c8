// What planning asks of the terrain: where the robot may stand, and how hard the ground is.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

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
///
/// Floors may lie above one another, so a place is three-dimensional: (x, y) and the height of the ground
/// there. It is answered for by the level whose ground is nearest to that height, at most kSameLevel_m away;
/// where no level is, nothing is known and nothing is free.
class TraversableGround {
 public:
  virtual ~TraversableGround() = default;

  /// More than the height of a place is off by: on ground of 22 degrees that of a place a step (0.6 m) away
  /// is 0.24 m, and localisation adds to that. At most half a storey, so that between floors of rooms (2 m
  /// apart, where a robot's operator walks upright) lie places that are on neither.
  static constexpr double kSameLevel_m = 0.5;
  static constexpr int kMaxLevels = 4;

  /// Heights of the ground at one (x, y), at most kMaxLevels; the level that the robot stands on first.
  struct Levels {
    std::array<double, kMaxLevels> height_m{};
    int count = 0;
    const double* begin() const { return height_m.data(); }
    const double* end() const { return height_m.data() + count; }
    bool empty() const { return count == 0; }
    double front() const { return height_m[0]; }
    void Add(double height) { height_m[static_cast<size_t>(count++)] = height; }
  };

  /// Mean height, slope (radians) and roughness (metres) under the footprint.
  struct Surface {
    double height_m = 0.0, slope_rad = 0.0, roughness_m = 0.0;
  };

  /// Where ground is, or is expected: what stands on it, or was not seen of it, has the height of the ground
  /// around. None where the terrain holds nothing.
  virtual Levels LevelsAt(const core::Vec2& p_map) const = 0;
  /// Traversability of the cell in [0, 1] (1 = flat, solid); 0 where unknown, an edge, or blocked.
  virtual double Traversability(const core::Vec3& p_map) const = 0;
  /// kFree exactly where the cell does not block the footprint.
  virtual GroundKind KindAt(const core::Vec3& p_map) const = 0;
  /// Whether the robot's footprint at this pose rests wholly on traversable cells with headroom.
  virtual bool FootprintFree(const core::Vec3& p_map, double yaw_rad) const = 0;
  /// As above for any heading (circle of the footprint's radius).
  virtual bool CircleFree(const core::Vec3& p_map) const = 0;
  /// Level ground at the robot's height where nothing is known.
  virtual Surface SurfaceAt(const core::Vec3& p_map) const = 0;
  /// Square that planning may use: centred on the robot, side window_m.
  virtual core::Box3 Window() const = 0;

  /// The same (x, y) on the level nearest to p_map's height, at most `reach_m` away.
  std::optional<core::Vec3> OnLevel(const core::Vec3& p_map, double reach_m = kSameLevel_m) const {
    std::optional<core::Vec3> nearest;
    for (const double height : LevelsAt(p_map.head<2>())) {
      const double apart = std::abs(height - p_map.z());
      if (apart > reach_m || (nearest && apart >= std::abs(nearest->z() - p_map.z()))) continue;
      nearest = core::Vec3(p_map.x(), p_map.y(), height);
    }
    return nearest;
  }
  /// On the level that the robot stands on, or at `otherwise_m` where the terrain holds nothing.
  core::Vec3 OnRobotsLevel(const core::Vec2& p_map, double otherwise_m) const {
    const Levels levels = LevelsAt(p_map);
    return {p_map.x(), p_map.y(), levels.empty() ? otherwise_m : levels.front()};
  }
};

}  // namespace atlas::mapping
