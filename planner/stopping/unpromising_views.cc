#include "planner/stopping/unpromising_views.h"

#include <algorithm>
#include <limits>

#include "planner/travel/costs.h"

namespace atlas::planner {
namespace {

using core::Vec2;

/// A place that is nearer to the object by less brings the robot no nearer.
constexpr double kNearer_m = 0.25;

double Distance(const Vec2& p, const core::Box3& object_box) {
  return object_box.DistanceTo(core::Vec3(p.x(), p.y(), object_box.Center().z()));
}

}  // namespace

double DistanceToObject(const std::vector<Vec2>& places, const core::Box3& object_box) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2& p : places) nearest = std::min(nearest, Distance(p, object_box));
  return nearest;
}

int FarthestFromScans(const std::vector<Candidate>& candidates, const std::vector<Vec2>& scans) {
  const auto farthest =
      std::max_element(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
        return DistanceToVisited(a.p_map, scans) < DistanceToVisited(b.p_map, scans);
      });
  return static_cast<int>(farthest - candidates.begin());
}

int NearestToObject(const std::vector<Candidate>& candidates, const std::vector<Vec2>& scans,
                    const core::Box3& object_box, double range_m) {
  double nearest = DistanceToObject(scans, object_box);
  if (nearest <= range_m) return -1;
  nearest -= kNearer_m;
  int best = -1;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const double there = Distance(candidates[i].p_map, object_box);
    if (there >= nearest) continue;
    nearest = there;
    best = static_cast<int>(i);
  }
  return best;
}

}  // namespace atlas::planner
