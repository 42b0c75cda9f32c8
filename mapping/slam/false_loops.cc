#include "mapping/slam/false_loops.h"

#include <algorithm>
#include <cmath>

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec6;

constexpr int kMostDraws = 1000;

class FalseLoopSource {
 public:
  FalseLoopSource(const FalseLoopOptions& options, core::Rng rng, const PoseGraph& graph)
      : options_(options), rng_(rng), graph_(graph) {
    for (const PoseEdge& edge : graph.edges) {
      if (edge.kind == EdgeKind::kLoop) true_loops_.push_back(edge);
    }
  }

  size_t Count() const {
    return static_cast<size_t>(
        std::llround(static_cast<double>(true_loops_.size()) * options_.share / (1.0 - options_.share)));
  }

  /// A run of loops that claim one relative pose; of a single loop unless they come in groups.
  std::vector<PoseEdge> Draw() {
    for (int draw = 0; draw < kMostDraws; ++draw) {
      std::vector<PoseEdge> run = Run(FirstPair());
      if (!run.empty()) return run;
    }
    return {};  // a graph that has no room for false loops
  }

 private:
  bool IsLocal() const {
    return options_.kind == FalseLoopKind::kLocal || options_.kind == FalseLoopKind::kLocalGroup;
  }
  bool InGroups() const {
    return options_.kind == FalseLoopKind::kRandomGroup || options_.kind == FalseLoopKind::kLocalGroup;
  }
  uint32_t Below(uint32_t n) { return static_cast<uint32_t>(rng_.UniformInt(static_cast<int>(n))); }

  std::pair<uint32_t, uint32_t> FirstPair() {
    const uint32_t from = Below(graph_.size());
    const uint32_t to = IsLocal() ? from + 2 + Below(options_.local_steps) : Below(graph_.size());
    return {std::min(from, to), std::max(from, to)};
  }

  Pose Claim() {
    Vec6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? options_.sigma_m : options_.sigma_rad) * rng_.Normal();
    if (graph_.planar) xi[2] = xi[3] = xi[4] = 0.0;
    return core::Exp(xi);
  }

  /// Loops (from + k, to + k) that claim what the first one does, carried along the way; none if a node is
  /// missing or the claim is nearly true.
  std::vector<PoseEdge> Run(std::pair<uint32_t, uint32_t> first) {
    const auto [from, to] = first;
    const uint32_t length = InGroups() ? options_.group : 1;
    if (to <= from + 1 || to + length > graph_.size()) return {};
    const Pose T_from_to = Claim(), T_true = T(from).inverse() * T(to);
    if ((T_from_to.translation() - T_true.translation()).norm() < options_.least_error_m) return {};
    std::vector<PoseEdge> run;
    for (uint32_t k = 0; k < length; ++k) {
      const auto like = static_cast<size_t>(rng_.UniformInt(static_cast<int>(true_loops_.size())));
      PoseEdge edge{from + k, to + k, Pose::Identity(), true_loops_[like].information, EdgeKind::kLoop};
      edge.T_from_to = (T(from + k).inverse() * T(from)) * T_from_to * (T(to).inverse() * T(to + k));
      run.push_back(edge);
    }
    return run;
  }

  const Pose& T(uint32_t node) const { return graph_.T_map_node[node]; }

  FalseLoopOptions options_;
  core::Rng rng_;
  const PoseGraph& graph_;
  std::vector<PoseEdge> true_loops_;
};

}  // namespace

size_t AddFalseLoops(const FalseLoopOptions& options, core::Rng rng, PoseGraph* graph) {
  FalseLoopSource source(options, rng, *graph);
  std::vector<PoseEdge> added;
  while (added.size() < source.Count()) {
    const std::vector<PoseEdge> run = source.Draw();
    if (run.empty()) break;
    added.insert(added.end(), run.begin(), run.end());
  }
  added.resize(std::min(added.size(), source.Count()));
  graph->edges.insert(graph->edges.end(), added.begin(), added.end());
  return added.size();
}

}  // namespace atlas::mapping
