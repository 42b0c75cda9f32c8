// Where the robot may stand and which straight steps it may take, remembered per plan.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "mapping/terrain/traversable_ground.h"

namespace atlas::planner {

/// Memoised view of the traversable ground for one plan. Positions are snapped to 5 cm and edge headings
/// to 7.5 degrees, both inside the clearance that the elevation map keeps from edges. Not thread-safe.
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
  bool CanStand(const core::Vec2& p_map) const;
  /// The footprint, heading along the step, is free all the way from a to b.
  bool CanStep(const core::Vec2& a, const core::Vec2& b) const;
  /// Effort of a straight step in metres: its length, up to three times as much on the worst traversable
  /// ground.
  double Effort(const core::Vec2& a, const core::Vec2& b) const;

  const core::Vec2& start() const { return start_; }
  const core::Box3& window() const { return window_; }
  const mapping::TraversableGround& ground() const { return ground_; }

 private:
  bool InEscape(const core::Vec2& p_map) const;
  bool FootprintFree(const core::Vec2& p_map, double yaw_rad, int heading) const;
  long CellOf(const core::Vec2& p_map) const;

  const mapping::TraversableGround& ground_;
  core::Vec2 start_;
  core::Box3 window_;
  int cols_ = 0, rows_ = 0;
  bool start_blocked_ = false;
  mutable std::vector<int8_t> circle_;     ///< 0 not asked, 1 free, -1 blocked
  mutable std::vector<int8_t> footprint_;  ///< by heading
};

}  // namespace atlas::planner
