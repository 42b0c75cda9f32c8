// What speaks against a view: where it stands and how it is reached (thesis 3.4.2, Eq. 3.1 and 3.7).
#pragma once

#include <vector>

#include "core/geometry.h"
#include "mapping/grid/occupied_index.h"
#include "mapping/map_view.h"
#include "planner/views/walkable.h"

namespace atlas::planner {

/// Eq. 3.7: 1 at no distance, falling linearly to 0 at the threshold and beyond.
/// @pre distance_m >= 0, threshold_m > 0.
double PositionCost(double distance_m, double threshold_m);

/// Eq. 3.1: gain x (1 - position cost) x (1 - traversal cost).
double Utility(double gain, double position_cost, double traversal_cost);

/// Distance from a point to the nearest place scanned so far; infinite where there is none.
double DistanceToVisited(const core::Vec2& p_map, const std::vector<core::Vec2>& visited);

/// The observed object as points: occupied voxels that stand above the ground around them.
class ObjectDistance {
 public:
  /// Of the voxels in a box those are the object that lie higher than `ground_m` + 0.15 m.
  ObjectDistance(const mapping::MapView& map, const core::Box3& box_map, double ground_m);
  /// To the nearest object voxel's centre, at most `limit_m`.
  double At(const core::Vec3& p_map, double limit_m) const;

 private:
  mapping::OccupiedIndex object_;
};

/// How the way to a view and the turn at its end are priced.
struct TraversalModel {
  double time_scale_s = 60.0;  ///< a way of this long costs 1 - 1/e
  double speed_mps = 0.5;      ///< on flat smooth ground
  double turn_rate_radps = 0.6;
  double slope_scale_rad = 0.38;  ///< slope or roughness of this much halves the speed
  double roughness_scale_m = 0.06;
};

/// Seconds to walk `path` from heading `yaw_rad` and end at `final_yaw_rad`: length, turns, slope, roughness.
double WalkTime(const TraversalModel& model, const Walkable& walkable, const std::vector<core::Vec3>& path,
                double yaw_rad, double final_yaw_rad);

/// Continuous traversal cost in [0, 1).
double ContinuousTraversalCost(const TraversalModel& model, double walk_time_s);

/// Whether a place lies behind a robot at this pose.
bool IsBehind(const core::Vec2& p_map, const core::Pose& T_map_base);

/// Both costs as one: 1 - (1 - a)(1 - b).
double CombineCosts(double a, double b);

}  // namespace atlas::planner
