#include "planner/candidates/candidates.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

#include "planner/candidates/ompl_bridge.h"

namespace atlas::planner {
namespace {

using core::Vec2;

/// Extensions tried for each node wanted, before the RRT settles for fewer.
constexpr int kAttemptsPerNode = 40;

}  // namespace

std::vector<Vec2> CandidateTree::PathTo(int node, const Vec2& start) const {
  std::vector<Vec2> path;
  for (int i = node; i >= 0; i = nodes[static_cast<size_t>(i)].parent) {
    path.push_back(nodes[static_cast<size_t>(i)].p_map);
  }
  path.push_back(start);
  std::reverse(path.begin(), path.end());
  return path;
}

CandidateTree RrtCandidates(const Walkable& walkable, int nodes, double step_m, const core::Rng& rng) {
  PlanarProblem problem;
  problem.start = walkable.start();
  problem.min = walkable.window().min.head<2>();
  problem.max = walkable.window().max.head<2>();
  problem.step_m = step_m;
  problem.can_stand = [&](const Vec2& p) { return walkable.CanStand(p); };
  problem.can_step = [&](const Vec2& a, const Vec2& b) { return walkable.CanStep(a, b); };
  const PlanarTree tree = GrowRrt(problem, nodes, kAttemptsPerNode * nodes, rng);

  CandidateTree result;
  result.attempts = tree.attempts;
  for (size_t i = 1; i < tree.points.size(); ++i) {  // the start was scanned already
    CandidateNode node;
    node.p_map = tree.points[i];
    node.parent = tree.parent[i] - 1;
    const double before =
        node.parent >= 0 ? result.nodes[static_cast<size_t>(node.parent)].path_length_m : 0.0;
    node.path_length_m = before + (node.p_map - tree.points[static_cast<size_t>(tree.parent[i])]).norm();
    node.ground_m = walkable.ground().SurfaceAt(node.p_map).height_m;
    result.nodes.push_back(node);
  }
  return result;
}

CandidateTree LatticeCandidates(const Walkable& walkable, double spacing_m, double passage_m) {
  using Cell = std::pair<int, int>;
  struct Entry {
    double length_m;
    Cell cell;
    int parent;
    bool operator>(const Entry& other) const {
      return std::tie(length_m, cell) > std::tie(other.length_m, other.cell);
    }
  };
  const auto point_of = [&](const Cell& c) { return Vec2(c.first * spacing_m, c.second * spacing_m); };
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::map<Cell, int> done;
  CandidateTree tree;

  const auto try_step = [&](const Vec2& from, double length_m, const Cell& next, int parent) {
    if (done.contains(next)) return;
    const Vec2 p = point_of(next);
    ++tree.attempts;
    if (!walkable.CanStand(p) || !walkable.CanStep(from, p)) return;
    open.push({length_m + (p - from).norm(), next, parent});
  };
  const auto expand = [&](const Vec2& from, double length_m, const Cell& centre, int reach, int parent) {
    for (int dx = -reach; dx <= reach; ++dx) {
      for (int dy = -reach; dy <= reach; ++dy) {
        try_step(from, length_m, {centre.first + dx, centre.second + dy}, parent);
      }
    }
  };
  const int far = static_cast<int>(std::floor(passage_m / spacing_m));
  /// Steps across ground where the robot cannot turn.
  const auto expand_passages = [&](const Vec2& from, double length_m, const Cell& centre, int parent) {
    for (int dx = -far; dx <= far; ++dx) {
      for (int dy = -far; dy <= far; ++dy) {
        if (std::max(std::abs(dx), std::abs(dy)) < 2 || std::hypot(dx, dy) * spacing_m > passage_m) continue;
        const Cell next{centre.first + dx, centre.second + dy};
        if (!walkable.CanStand(0.5 * (from + point_of(next)))) try_step(from, length_m, next, parent);
      }
    }
  };

  const Vec2& start = walkable.start();
  const Cell first{static_cast<int>(std::lround(start.x() / spacing_m)),
                   static_cast<int>(std::lround(start.y() / spacing_m))};
  expand(start, 0.0, first, 2, -1);
  while (!open.empty()) {
    const Entry entry = open.top();
    open.pop();
    if (!done.emplace(entry.cell, static_cast<int>(tree.nodes.size())).second) continue;
    const Vec2 p = point_of(entry.cell);
    tree.nodes.push_back({p, entry.parent, entry.length_m, walkable.ground().SurfaceAt(p).height_m});
    expand(p, entry.length_m, entry.cell, 1, static_cast<int>(tree.nodes.size()) - 1);
    if (far > 1) expand_passages(p, entry.length_m, entry.cell, static_cast<int>(tree.nodes.size()) - 1);
  }
  return tree;
}

std::vector<int> SpreadOut(const std::vector<CandidateNode>& nodes, const Vec2& start, int count) {
  std::vector<double> gap(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) gap[i] = (nodes[i].p_map - start).squaredNorm();
  std::vector<int> chosen;
  while (chosen.size() < std::min(nodes.size(), static_cast<size_t>(std::max(count, 0)))) {
    const size_t best = static_cast<size_t>(std::max_element(gap.begin(), gap.end()) - gap.begin());
    chosen.push_back(static_cast<int>(best));
    for (size_t i = 0; i < nodes.size(); ++i) {
      gap[i] = std::min(gap[i], (nodes[i].p_map - nodes[best].p_map).squaredNorm());
    }
    gap[best] = -1.0;
  }
  return chosen;
}

}  // namespace atlas::planner
