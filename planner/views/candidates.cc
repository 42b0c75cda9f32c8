#include "planner/views/candidates.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <queue>
#include <set>
#include <tuple>

#include "planner/views/ompl_bridge.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

/// Extensions tried for each node wanted, before the RRT settles for fewer.
constexpr int kAttemptsPerNode = 40;

}  // namespace

std::vector<Vec3> CandidateTree::PathTo(int node, const Vec3& start) const {
  std::vector<Vec3> path;
  for (int i = node; i >= 0; i = nodes[static_cast<size_t>(i)].parent) {
    path.push_back(nodes[static_cast<size_t>(i)].place());
  }
  path.push_back(start);
  std::reverse(path.begin(), path.end());
  return path;
}

std::vector<size_t> CandidateTree::NarrowSteps(int node) const {
  std::vector<bool> narrow;  // from the node backwards
  for (int i = node; i >= 0; i = nodes[static_cast<size_t>(i)].parent) {
    narrow.push_back(nodes[static_cast<size_t>(i)].narrow);
  }
  std::vector<size_t> steps;
  for (size_t i = 0; i < narrow.size(); ++i) {
    if (narrow[narrow.size() - 1 - i]) steps.push_back(i);
  }
  return steps;
}

CandidateTree RrtCandidates(const Walkable& walkable, int nodes, double step_m, const core::Rng& rng) {
  GroundProblem problem;
  problem.start = walkable.start();
  problem.min = walkable.window().min.head<2>();
  problem.max = walkable.window().max.head<2>();
  problem.step_m = step_m;
  FollowGroundOf(walkable, &problem);
  const GroundTree tree = GrowRrt(problem, nodes, kAttemptsPerNode * nodes, rng);

  CandidateTree result;
  result.attempts = tree.attempts;
  for (size_t i = 1; i < tree.points.size(); ++i) {  // the start was scanned already
    CandidateNode node;
    node.p_map = tree.points[i].head<2>();
    node.parent = tree.parent[i] - 1;
    const double before =
        node.parent >= 0 ? result.nodes[static_cast<size_t>(node.parent)].path_length_m : 0.0;
    node.path_length_m =
        before + (node.p_map - tree.points[static_cast<size_t>(tree.parent[i])].head<2>()).norm();
    node.ground_m = walkable.ground().SurfaceAt(tree.points[i]).height_m;
    result.nodes.push_back(node);
  }
  return result;
}

namespace {

/// Dijkstra over the places of a lattice and the ends of passages.
class LatticeSearch {
 public:
  LatticeSearch(const Walkable& walkable, double spacing_m, double long_step_m, std::vector<Passage> passages)
      : walkable_(walkable),
        spacing_m_(spacing_m),
        long_step_m_(long_step_m),
        passages_(std::move(passages)) {}

  CandidateTree Run() {
    ExpandStart();
    while (!open_.empty()) {
      const Entry entry = open_.top();
      open_.pop();
      if (!done_.insert(entry.stop).second) continue;
      const Vec2 p_map = PointOf(entry.stop);
      const Vec3 p(p_map.x(), p_map.y(), entry.stop.height_m);
      const int node = static_cast<int>(tree_.nodes.size());
      tree_.nodes.push_back(
          {p_map, entry.parent, entry.length_m, walkable_.ground().SurfaceAt(p).height_m, entry.narrow});
      Expand(entry.stop, p, entry.length_m, node);
    }
    return std::move(tree_);
  }

 private:
  /// A lattice place (end < 0) or end `end` % 2 of passage `end` / 2; one above the other on two floors are
  /// two places. The terrain has one height for a place, whichever way leads there.
  struct Stop {
    int end, x, y;
    double height_m = 0.0;
    auto operator<=>(const Stop&) const = default;
  };
  struct Entry {
    double length_m;
    Stop stop;
    int parent;
    bool narrow;
    bool operator>(const Entry& other) const {
      return std::tie(length_m, stop) > std::tie(other.length_m, other.stop);
    }
  };

  Vec2 PointOf(const Stop& stop) const {
    if (stop.end < 0) return {stop.x * spacing_m_, stop.y * spacing_m_};
    const Passage& passage = passages_[static_cast<size_t>(stop.end / 2)];
    return (stop.end % 2 == 0 ? passage.a : passage.b).head<2>();
  }
  Stop LatticeStopNear(const Vec3& p) const {
    return {-1, static_cast<int>(std::lround(p.x() / spacing_m_)),
            static_cast<int>(std::lround(p.y() / spacing_m_))};
  }

  void TryStep(const Vec3& from, double length_m, Stop next, int parent) {
    const auto to = Reached(from, PointOf(next));
    next.height_m = to.z();
    if (done_.contains(next)) return;
    ++tree_.attempts;
    if (!walkable_.CanStand(to) || !walkable_.CanStep(from, to)) return;
    open_.push({length_m + (to - from).head<2>().norm(), next, parent, false});
  }
  /// Of one floor above another, that to which the ground leads.
  Vec3 Reached(const Vec3& from, const Vec2& p) const {
    if (walkable_.ground().LevelsAt(p).count < 2) return walkable_.ground().OnRobotsLevel(p, from.z());
    return walkable_.FollowGround(from, p).value_or(walkable_.ground().OnRobotsLevel(p, from.z()));
  }
  void TryLattice(const Vec3& from, double length_m, const Stop& centre, int reach, int parent) {
    for (int dx = -reach; dx <= reach; ++dx) {
      for (int dy = -reach; dy <= reach; ++dy) {
        TryStep(from, length_m, {-1, centre.x + dx, centre.y + dy}, parent);
      }
    }
  }
  /// Steps across ground where the robot cannot turn.
  void TryLongSteps(const Vec3& from, double length_m, const Stop& centre, int parent) {
    const int far = static_cast<int>(std::floor(long_step_m_ / spacing_m_));
    for (int dx = -far; dx <= far; ++dx) {
      for (int dy = -far; dy <= far; ++dy) {
        if (std::max(std::abs(dx), std::abs(dy)) < 2 || std::hypot(dx, dy) * spacing_m_ > long_step_m_) {
          continue;
        }
        const Stop next{-1, centre.x + dx, centre.y + dy};
        const Vec2 middle = 0.5 * (from.head<2>() + PointOf(next));
        if (!walkable_.CanStand(Reached(from, middle))) TryStep(from, length_m, next, parent);
      }
    }
  }
  void TryPassageEnds(const Vec3& from, double length_m, double reach_m, int parent) {
    for (int end = 0; end < 2 * static_cast<int>(passages_.size()); ++end) {
      const Stop stop{end, 0, 0};
      if ((PointOf(stop) - from.head<2>()).norm() <= reach_m) TryStep(from, length_m, stop, parent);
    }
  }

  void ExpandStart() {
    const Vec3& start = walkable_.start();
    TryLattice(start, 0.0, LatticeStopNear(start), 2, -1);
    TryPassageEnds(start, 0.0, kStartReach_m, -1);
  }
  void Expand(const Stop& stop, const Vec3& p, double length_m, int node) {
    TryLattice(p, length_m, LatticeStopNear(p), stop.end < 0 ? 1 : 2, node);
    TryPassageEnds(p, length_m, kEndReach * spacing_m_, node);
    if (stop.end < 0) {
      TryLongSteps(p, length_m, stop, node);
      return;
    }
    const Passage& passage = passages_[static_cast<size_t>(stop.end / 2)];
    Stop other{stop.end ^ 1, 0, 0};
    other.height_m = (other.end % 2 == 0 ? passage.a : passage.b).z();
    if (done_.contains(other)) return;
    open_.push({length_m + (PointOf(other) - p.head<2>()).norm(), other, node, true});
  }

  /// A robot that stands in a doorway gets out of it.
  static constexpr double kStartReach_m = 1.6;
  static constexpr double kEndReach = 1.5;  ///< lattice spacings from a place to the end of a passage

  const Walkable& walkable_;
  double spacing_m_, long_step_m_;
  std::vector<Passage> passages_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
  std::set<Stop> done_;
  CandidateTree tree_;
};

}  // namespace

CandidateTree LatticeCandidates(const Walkable& walkable, double spacing_m, double long_step_m,
                                std::vector<Passage> passages) {
  return LatticeSearch(walkable, spacing_m, long_step_m, std::move(passages)).Run();
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
