// Where the robot may stand and which straight steps it may take, remembered per plan.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "mapping/terrain/traversable_ground.h"

namespace atlas::planner {

/// Memoised view of the traversable ground for one plan. Places are (x, y) and the height of the ground
/// there, for floors may lie above one another; a step follows the ground from its start, so that it ends on
/// the floor that leads there. Positions are snapped to 5 cm and edge headings to 7.5 degrees, both inside
/// the clearance that the elevation map keeps from edges. Not thread-safe.
///
/// The robot may have to leave a place that is marginally invalid: where it cannot stand at `start`, points
/// within 0.45 m of it count as free as long as the inner disc (0.35 m) there is traversable.
class Walkable {
 public:
  /// Planning uses the part of the ground's window that lies in the square of side `window_m` about the
  /// start.
  Walkable(const mapping::TraversableGround& ground, const core::Vec2& start,
           double window_m = std::numeric_limits<double>::infinity());

  /// The robot fits at any heading.
  bool CanStand(const core::Vec3& p_map) const;
  /// The footprint, heading along the step, is free all the way from a to b, and the ground leads there.
  bool CanStep(const core::Vec3& a, const core::Vec3& b) const;
  /// Where the ground leads on the straight way from a place to (x, y), whether it is free or not; nothing
  /// where it ends.
  std::optional<core::Vec3> FollowGround(const core::Vec3& from, const core::Vec2& to) const;
  /// Effort of a straight step in metres: its length, up to three times as much on the worst traversable
  /// ground.
  double Effort(const core::Vec3& a, const core::Vec3& b) const;

  /// On the level that the robot stands on.
  const core::Vec3& start() const { return start_; }
  const core::Box3& window() const { return window_; }
  const mapping::TraversableGround& ground() const { return ground_; }

 private:
  /// What was asked of one floor, by cell.
  struct Storey {
    std::vector<float> height_m;    ///< of the floor; NaN where not asked
    std::vector<int8_t> circle;     ///< 0 not asked, 1 free, -1 blocked
    std::vector<int8_t> footprint;  ///< by heading
  };
  bool InEscape(const core::Vec3& p_map) const;
  bool FootprintFree(const core::Vec3& p_map, double yaw_rad, int heading) const;
  long CellOf(const core::Vec3& p_map) const;
  Storey& StoreyAt(size_t cell, double height_m) const;

  const mapping::TraversableGround& ground_;
  core::Vec3 start_;
  core::Box3 window_;
  int cols_ = 0, rows_ = 0;
  bool start_blocked_ = false;
  mutable std::vector<Storey> storeys_;
};

}  // namespace atlas::planner
