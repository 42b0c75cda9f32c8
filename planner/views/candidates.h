// Where the robot could scan next: places it can reach, and how (thesis 3.5, first phase).
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/rng.h"
#include "planner/views/passages.h"
#include "planner/views/walkable.h"

namespace atlas::planner {

/// A place and the way to it, as a tree from the robot.
struct CandidateNode {
  core::Vec2 p_map = core::Vec2::Zero();
  int parent = -1;             ///< -1: reached straight from the robot
  double path_length_m = 0.0;  ///< along the tree from the robot
  double ground_m = 0.0;       ///< height of the ground under the footprint
  bool narrow = false;         ///< the step here from its parent leads through a passage

  core::Vec3 place() const { return {p_map.x(), p_map.y(), ground_m}; }
};

struct CandidateTree {
  std::vector<CandidateNode> nodes;
  int attempts = 0;

  /// Waypoints from the robot (its own position first) to a node.
  std::vector<core::Vec3> PathTo(int node, const core::Vec3& start) const;
  /// Of that way: the indices of waypoints from which the step to the next leads through a passage.
  std::vector<size_t> NarrowSteps(int node) const;
};

/// Where a plan may go: what it may walk on, and the places that it reached.
struct Ways {
  const Walkable& walkable;
  const CandidateTree& tree;
};

/// RRT nodes as in the thesis, at most `nodes` of them.
CandidateTree RrtCandidates(const Walkable& walkable, int nodes, double step_m, const core::Rng& rng);

/// Every point of a lattice with this spacing (multiples of it in the map, so that places repeat between
/// plans) that can be reached by free steps between neighbours and through `passages`; each with its shortest
/// way. The ends of passages reached are places too. Where the robot fits on its way but could not turn, also
/// steps of up to `long_step_m` between places of the lattice are tried.
CandidateTree LatticeCandidates(const Walkable& walkable, double spacing_m, double long_step_m = 0.0,
                                std::vector<Passage> passages = {});

/// At most `count` indices of nodes that are spread out: repeatedly the one farthest from all chosen so far
/// and from `start` (ties: the lower index).
std::vector<int> SpreadOut(const std::vector<CandidateNode>& nodes, const core::Vec2& start, int count);

}  // namespace atlas::planner
