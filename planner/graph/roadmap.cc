#include "planner/graph/roadmap.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>
#include <tuple>

namespace atlas::planner {

using core::Vec2;

Roadmap::Cell Roadmap::CellOf(const Vec2& p_map) {
  return {static_cast<int>(std::lround(p_map.x() / kSamePlace_m)),
          static_cast<int>(std::lround(p_map.y() / kSamePlace_m))};
}

void Roadmap::Correct(const core::PoseSource& poses) {
  if (poses.version() == version_) return;
  version_ = poses.version();
  corrected_ = !places_.empty();
  at_.clear();
  for (size_t i = 0; i < places_.size(); ++i) {
    const core::Vec3 p = places_[i].anchor.p_map(poses);
    places_[i].p_map = p.head<2>();
    places_[i].ground_m = p.z();
    const auto [oldest, alone] = at_.emplace(CellOf(places_[i].p_map), i);
    if (!alone) Join(oldest->second, i, false);
  }
}

void Roadmap::Join(size_t a, size_t b, bool narrow) {
  if (a == b) return;
  const auto add = [&](size_t from, size_t to) {
    std::vector<Step>& steps = places_[from].steps;
    const bool known = std::any_of(steps.begin(), steps.end(), [&](const Step& s) { return s.to == to; });
    if (!known) steps.push_back({to, narrow});
  };
  add(a, b);
  add(b, a);
}

void Roadmap::JoinToNear(size_t place) {
  const Cell cell = CellOf(places_[place].p_map);
  const int reach = static_cast<int>(std::lround(kNear_m / kSamePlace_m));
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      const auto near = at_.find({cell.first + dx, cell.second + dy});
      if (near == at_.end()) continue;
      if ((places_[near->second].p_map - places_[place].p_map).norm() <= kNear_m) {
        Join(near->second, place, false);
      }
    }
  }
}

void Roadmap::Learn(const CandidateTree& tree, const core::PoseSource& poses) {
  Correct(poses);
  const size_t known = places_.size();
  for (const CandidateNode& node : tree.nodes) {
    const auto [at, is_new] = at_.emplace(CellOf(node.p_map), places_.size());
    if (is_new) places_.emplace_back();
    Place& place = places_[at->second];
    place.anchor = core::AnchoredPoint::At(core::Vec3(node.p_map.x(), node.p_map.y(), node.ground_m), poses);
    place.p_map = node.p_map;
    place.ground_m = node.ground_m;
  }
  if (corrected_) {
    for (size_t i = known; i < places_.size(); ++i) JoinToNear(i);
  }
  for (const CandidateNode& node : tree.nodes) {
    if (node.parent < 0) continue;
    Join(at_.at(CellOf(node.p_map)), at_.at(CellOf(tree.nodes[static_cast<size_t>(node.parent)].p_map)),
         node.narrow);
  }
}

void Roadmap::Extend(CandidateTree* tree) const {
  using Entry = std::tuple<double, Cell, int, bool, size_t>;  // length, cell, parent node, narrow, place
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::set<size_t> done;
  for (const CandidateNode& node : tree->nodes) {
    if (const auto at = at_.find(CellOf(node.p_map)); at != at_.end()) done.insert(at->second);
  }

  const auto expand = [&](int node, size_t place) {
    const CandidateNode& from = tree->nodes[static_cast<size_t>(node)];
    for (const Step& step : places_[place].steps) {
      if (done.contains(step.to)) continue;
      const Vec2& p_map = places_[step.to].p_map;
      open.emplace(from.path_length_m + (p_map - from.p_map).norm(), CellOf(p_map), node, step.narrow,
                   step.to);
    }
  };
  const int seeds = static_cast<int>(tree->nodes.size());
  for (int node = 0; node < seeds; ++node) {
    const auto at = at_.find(CellOf(tree->nodes[static_cast<size_t>(node)].p_map));
    if (at != at_.end()) expand(node, at->second);
  }
  while (!open.empty()) {
    const auto [length_m, cell, parent, narrow, at] = open.top();
    open.pop();
    if (!done.insert(at).second) continue;
    tree->nodes.push_back({places_[at].p_map, parent, length_m, places_[at].ground_m, narrow});
    expand(static_cast<int>(tree->nodes.size()) - 1, at);
  }
}

}  // namespace atlas::planner
