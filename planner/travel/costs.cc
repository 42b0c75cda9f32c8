#include "planner/travel/costs.h"

#include <algorithm>
#include <cmath>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kGroundBand_m = 0.15;

}  // namespace

double PositionCost(double distance_m, double threshold_m) {
  return distance_m > threshold_m ? 0.0 : 1.0 - distance_m / threshold_m;  // Eq. 3.7
}

double Utility(double gain, double position_cost, double traversal_cost) {
  return gain * (1.0 - position_cost) * (1.0 - traversal_cost);  // Eq. 3.1
}

double DistanceToVisited(const Vec2& p_map, const std::vector<Vec2>& visited) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2& q : visited) nearest = std::min(nearest, (p_map - q).norm());
  return nearest;
}

ObjectDistance::ObjectDistance(const mapping::MapView& map, const core::Box3& box_map, double ground_m)
    : object_(box_map) {
  std::vector<core::Vec3f> centers = mapping::OccupiedCenters(map, box_map);
  std::erase_if(centers, [&](const core::Vec3f& p) { return p.z() <= ground_m + kGroundBand_m; });
  object_.Build(std::move(centers));
}

double ObjectDistance::At(const Vec3& p_map, double limit_m) const {
  return object_.DistanceTo(p_map, limit_m);
}

double WalkTime(const TraversalModel& model, const Walkable& walkable, const std::vector<Vec3>& path,
                double yaw_rad, double final_yaw_rad) {
  double time_s = 0.0, turned_rad = 0.0, heading = yaw_rad;
  for (size_t i = 1; i < path.size(); ++i) {
    const Vec2 step = (path[i] - path[i - 1]).head<2>();
    if (step.norm() < 1e-6) continue;
    const double yaw = std::atan2(step.y(), step.x());
    turned_rad += std::abs(core::WrapAngle(yaw - heading));
    heading = yaw;
    const mapping::TraversableGround::Surface surface =
        walkable.ground().SurfaceAt(0.5 * (path[i] + path[i - 1]));
    const double hardship = std::min(1.0, std::max(std::abs(surface.slope_rad) / model.slope_scale_rad,
                                                   surface.roughness_m / model.roughness_scale_m));
    time_s += step.norm() / (model.speed_mps * (1.0 - 0.5 * hardship));
  }
  turned_rad += std::abs(core::WrapAngle(final_yaw_rad - heading));
  return time_s + turned_rad / model.turn_rate_radps;
}

double ContinuousTraversalCost(const TraversalModel& model, double walk_time_s) {
  return 1.0 - std::exp(-walk_time_s / model.time_scale_s);
}

bool IsBehind(const Vec2& p_map, const core::Pose& T_map_base) {
  const Vec2 to_p = p_map - T_map_base.translation().head<2>();
  return to_p.dot(T_map_base.linear().col(0).head<2>()) < 0.0;
}

double CombineCosts(double a, double b) {
  return 1.0 - (1.0 - a) * (1.0 - b);
}

}  // namespace atlas::planner
