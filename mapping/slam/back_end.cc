#include "mapping/slam/back_end.h"

#include <algorithm>
#include <utility>

namespace atlas::mapping {

namespace {

/// Two ways in which a session may lie are one where they differ by less.
constexpr double kSameM = 0.3, kSameDeg = 3.0;

bool Agree(const core::Pose& a, const core::Pose& b) {
  const core::Pose between = a.inverse() * b;
  return between.translation().norm() < kSameM &&
         Eigen::AngleAxisd(between.linear()).angle() < core::Radians(kSameDeg);
}

}  // namespace

SlamBackEnd::SlamBackEnd(const SlamParams& params, const core::Pose& T_map_first,
                         const std::shared_ptr<const SlamMemory>& earlier)
    : params_(params),
      graph_(earlier ? PoseGraphSlam(earlier->graph) : PoseGraphSlam(T_map_first)),
      search_(params),
      T_map_first_(T_map_first),
      located_(!earlier) {
  if (!earlier) return;
  begin_ = earlier->graph.size();
  for (uint32_t node = 0; node < begin_; ++node)
    search_.Recall(earlier->nodes[node], earlier->graph.T_map_node[node]);
}

SolvedNodes SlamBackEnd::Take(const FinishedNode& node) {
  if (!std::exchange(first_, false)) {
    graph_.AddNode(node.T_previous_node, node.information);
  } else if (begin_ > 0) {
    graph_.AddUnconnected(T_map_first_);
  }
  if (params_.loop_tries == 0) return Solved();
  search_.Add(node.cloud, graph_.T_map_node().back());
  const std::vector<Loop> loops = located_ ? search_.FromLatest(graph_.InlierGraph()) : Locate();
  for (const Loop& loop : loops) graph_.AddLoop(loop.from, loop.to, loop.T_from_to, loop.information);
  if (!loops.empty()) graph_.Resolve();
  loops_ += loops.size();
  loops_since_full_pass_ += loops.size();
  return Solved();
}

std::vector<Loop> SlamBackEnd::Locate() {
  const std::vector<core::Pose>& T_map_node = graph_.T_map_node();
  // The session's first node in the map, as a loop has it.
  const auto first_by = [&](const Loop& loop) {
    return T_map_node[loop.from] * loop.T_from_to * T_map_node[loop.to].inverse() * T_map_node[begin_];
  };
  for (const Loop& loop : search_.ToRecalled(graph_.graph())) {
    waiting_.push_back(loop);
    const auto agrees = [&](const Loop& other) { return Agree(first_by(other), first_by(loop)); };
    located_ = located_ || std::any_of(waiting_.begin(), waiting_.end() - 1, agrees);
  }
  if (!located_) return {};
  const auto seconded = [&](const Loop& loop) {
    return std::count_if(waiting_.begin(), waiting_.end(),
                         [&](const Loop& other) { return Agree(first_by(other), first_by(loop)); }) > 1;
  };
  std::erase_if(waiting_, [&](const Loop& loop) { return !seconded(loop); });
  graph_.MoveFrom(begin_, first_by(waiting_.back()));
  return std::exchange(waiting_, {});
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
  return {graph_.T_map_node(), graph_.version(), due, inliers_, located_};
}

}  // namespace atlas::mapping
