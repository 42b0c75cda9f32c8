#include "mapping/slam/back_end.h"

#include <utility>

namespace atlas::mapping {

SlamBackEnd::SlamBackEnd(const SlamParams& params, const core::Pose& T_map_first)
    : params_(params), graph_(T_map_first), search_(params) {}

SolvedNodes SlamBackEnd::Take(const FinishedNode& node) {
  if (!std::exchange(first_, false)) graph_.AddNode(node.T_previous_node, node.information);
  if (params_.loop_tries == 0) return Solved();
  search_.Add(node.cloud, graph_.T_map_node().back());
  const std::vector<Loop> loops = search_.FromLatest(graph_.InlierGraph());
  for (const Loop& loop : loops) graph_.AddLoop(loop.from, loop.to, loop.T_from_to, loop.information);
  if (!loops.empty()) graph_.Resolve();
  loops_ += loops.size();
  loops_since_full_pass_ += loops.size();
  return Solved();
}

SolvedNodes SlamBackEnd::FullPass() {
  loops_since_full_pass_ = 0;
  graph_.Adopt(SolveFully(graph_.graph()));
  return Solved();
}

SolvedNodes SlamBackEnd::Solved() {
  constexpr size_t kShare = 10;
  const bool due = loops_since_full_pass_ > 0 && kShare * loops_since_full_pass_ >= loops_;
  const bool moved = std::exchange(inliers_version_, graph_.version()) != graph_.version();
  if (!inliers_ || moved) inliers_ = std::make_shared<const PoseGraph>(graph_.InlierGraph());
  return {graph_.T_map_node(), graph_.version(), due, inliers_};
}

}  // namespace atlas::mapping
