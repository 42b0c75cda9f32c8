#include "planner/travel/view_costs.h"

#include <algorithm>
#include <optional>

namespace atlas::planner {

using core::Vec2;
using core::Vec3;

void CostParams::Visit(core::ParamVisitor& v) {
  v.Field("visited_cost", &visited_cost, {.doc = "position cost near places already scanned (Eq. 3.7)"});
  v.Field("visited_threshold_m", &visited_threshold_m,
          {.unit = "m", .min = 0.05, .max = 20.0, .doc = "d_thres of the visited term"});
  v.Field("too_close_cost", &too_close_cost, {.doc = "position cost near the object (Eq. 3.7)"});
  v.Field("too_close_threshold_m", &too_close_threshold_m,
          {.unit = "m", .min = 0.05, .max = 20.0, .doc = "d_thres of the too-close term"});
  v.Field(
      "behind_penalty", &behind_penalty,
      {.min = 0.0, .max = 1.0, .doc = "constant traversal cost of views behind the robot (thesis 3.4.2)"});
  v.Field("traversal", &traversal,
          {.choices = {"discrete", "continuous"},
           .doc = "discrete: reachable costs nothing (thesis); continuous: time, slope, roughness, turning"});
  v.Field("time_scale_s", &time_scale_s,
          {.unit = "s", .min = 1.0, .max = 1e6, .doc = "continuous: a way of this long costs 1 - 1/e"});
}

ViewCosts::ViewCosts(const CostParams& params, const PlannerSetup& setup, double sensor_height_m)
    : params_(params), kept_map_(setup.kept_map), sensor_height_m_(sensor_height_m) {
  traversal_.speed_mps = setup.robot.speed_mps;
  traversal_.time_scale_s = params.time_scale_s;
  traversal_.slope_scale_rad = core::Radians(setup.terrain.critical_slope_deg);
  traversal_.roughness_scale_m = setup.terrain.critical_roughness_m;
}

void ViewCosts::Charge(const Belief& belief, const Ways& ways, const std::vector<Vec2>& scanned,
                       DecisionLog* log) const {
  const double yaw = core::YawOf(belief.T_map_base.linear());
  std::optional<ObjectDistance> object;
  if (params_.too_close_cost) {
    object.emplace(belief.map, kept_map_, ways.walkable.ground().SurfaceAt(ways.walkable.start()).height_m);
  }
  for (Candidate& c : log->candidates) {
    if (params_.visited_cost) {
      c.visited_cost = PositionCost(DistanceToVisited(c.p_map, scanned), params_.visited_threshold_m);
    }
    if (object) {
      const Vec3 sensor(c.p_map.x(), c.p_map.y(), c.ground_m + sensor_height_m_);
      const double distance = object->At(sensor, params_.too_close_threshold_m + 0.1);
      c.too_close_cost = PositionCost(distance, params_.too_close_threshold_m);
    }
    c.position_cost = std::max(c.visited_cost, c.too_close_cost);
    const double penalty = IsBehind(c.p_map, belief.T_map_base) ? params_.behind_penalty : 0.0;
    double way = 0.0;  // the thesis's classes: what the tree reaches is safe
    if (params_.traversal == "continuous") {
      const std::vector<Vec3> path = ways.tree.PathTo(c.node, ways.walkable.start());
      way = ContinuousTraversalCost(traversal_, WalkTime(traversal_, ways.walkable, path, yaw, c.yaw_rad));
    }
    c.traversal_cost = CombineCosts(way, penalty);
    c.utility = Utility(*c.worth, c.position_cost, c.traversal_cost);
  }
}

}  // namespace atlas::planner
