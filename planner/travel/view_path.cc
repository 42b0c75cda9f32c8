#include "planner/travel/view_path.h"

#include <algorithm>

#include "planner/views/ompl_bridge.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

/// RRT* searches the bounding box of the tree path grown by this.
constexpr double kSearchMargin_m = 1.5;
constexpr double kLongestEdge_m = 1.0;
/// Effort of a long step is summed over pieces of this length.
constexpr double kEffortPiece_m = 0.25;

double EffortAlong(const Walkable& walkable, const Vec3& a, const Vec3& b) {
  const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).head<2>().norm() / kEffortPiece_m)));
  double effort = 0.0;
  for (int i = 0; i < pieces; ++i) {
    effort += walkable.Effort(a + (b - a) * (static_cast<double>(i) / pieces),
                              a + (b - a) * (static_cast<double>(i + 1) / pieces));
  }
  return effort;
}

double EffortOf(const Walkable& walkable, const std::vector<Vec3>& path) {
  double effort = 0.0;
  for (size_t i = 1; i < path.size(); ++i) effort += EffortAlong(walkable, path[i - 1], path[i]);
  return effort;
}

GroundProblem ProblemAround(const Walkable& walkable, const std::vector<Vec3>& tree_path) {
  GroundProblem problem;
  problem.start = tree_path.front();
  problem.min = problem.max = tree_path.front().head<2>();
  for (const Vec3& p : tree_path) {
    problem.min = problem.min.cwiseMin(p.head<2>());
    problem.max = problem.max.cwiseMax(p.head<2>());
  }
  const Vec2 margin = Vec2::Constant(kSearchMargin_m);
  problem.min = (problem.min - margin).cwiseMax(walkable.window().min.head<2>());
  problem.max = (problem.max + margin).cwiseMin(walkable.window().max.head<2>());
  problem.step_m = kLongestEdge_m;
  FollowGroundOf(walkable, &problem);
  problem.effort = [&](const Vec3& a, const Vec3& b) { return EffortAlong(walkable, a, b); };
  return problem;
}

}  // namespace

double PathLength(const std::vector<Vec2>& path) {
  double length = 0.0;
  for (size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

double PathLength(const std::vector<Vec3>& path) {
  double length = 0.0;
  for (size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).head<2>().norm();
  return length;
}

std::vector<Vec3> Shortcut(const Walkable& walkable, const std::vector<Vec3>& path) {
  if (path.size() < 3) return path;
  // The cheapest way through the waypoints in order: a shortest path over all free skips.
  const size_t n = path.size();
  std::vector<double> cost(n, std::numeric_limits<double>::infinity());
  std::vector<size_t> before(n, 0);
  cost[0] = 0.0;
  for (size_t j = 1; j < n; ++j) {
    for (size_t i = 0; i < j; ++i) {
      const double through = cost[i] + EffortAlong(walkable, path[i], path[j]);
      if (through > cost[j] + 1e-9 * (j - i)) continue;
      if (j - i > 1 && !walkable.CanStep(path[i], path[j])) continue;
      cost[j] = through;
      before[j] = i;
    }
  }
  std::vector<Vec3> result = {path.back()};
  for (size_t j = n - 1; j > 0; j = before[j]) result.push_back(path[before[j]]);
  std::reverse(result.begin(), result.end());
  return result;
}

std::vector<Vec3> PlanViewPath(const Walkable& walkable, const std::vector<Vec3>& tree_path, int iterations,
                               const core::Rng& rng) {
  const std::vector<Vec3> straightened = Shortcut(walkable, tree_path);
  const bool known = std::all_of(tree_path.begin(), tree_path.end(), [&](const Vec3& p) {
    return walkable.window().Contains(core::Vec3(p.x(), p.y(), walkable.window().Center().z()));
  });
  if (straightened.size() <= 2 || iterations <= 0 || !known) return straightened;
  const auto found = PlanRrtStar(ProblemAround(walkable, tree_path), tree_path.back(), iterations, rng);
  if (!found) return straightened;
  std::vector<Vec3> optimised = Shortcut(walkable, *found);
  return EffortOf(walkable, optimised) < EffortOf(walkable, straightened) ? optimised : straightened;
}

std::vector<Vec3> PlanViewPath(const Walkable& walkable, const std::vector<Vec3>& tree_path,
                               const std::vector<size_t>& narrow, int iterations, const core::Rng& rng) {
  if (narrow.empty()) return PlanViewPath(walkable, tree_path, iterations, rng);
  std::vector<Vec3> path;
  size_t from = 0;
  for (size_t k = 0; k <= narrow.size(); ++k) {
    const size_t to = k < narrow.size() ? narrow[k] : tree_path.size() - 1;
    const std::vector<Vec3> piece(tree_path.begin() + static_cast<std::ptrdiff_t>(from),
                                  tree_path.begin() + static_cast<std::ptrdiff_t>(to) + 1);
    const std::vector<Vec3> way =
        PlanViewPath(walkable, piece, iterations, rng.Split("piece" + std::to_string(k)));
    path.insert(path.end(), way.begin(), way.end());
    from = to + 1;
  }
  return path;
}

}  // namespace atlas::planner
