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

void Roadmap::Join(const Cell& a, const Cell& b, bool narrow) {
  if (a == b) return;
  const auto add = [&](const Cell& from, const Cell& to) {
    std::vector<Step>& steps = places_.at(from).steps;
    const bool known = std::any_of(steps.begin(), steps.end(), [&](const Step& s) { return s.to == to; });
    if (!known) steps.push_back({to, narrow});
  };
  add(a, b);
  add(b, a);
}

void Roadmap::Learn(const CandidateTree& tree) {
  for (const CandidateNode& node : tree.nodes) {
    Place& place = places_[CellOf(node.p_map)];
    place.p_map = node.p_map;
    place.ground_m = node.ground_m;
  }
  for (const CandidateNode& node : tree.nodes) {
    if (node.parent < 0) continue;
    Join(CellOf(node.p_map), CellOf(tree.nodes[static_cast<size_t>(node.parent)].p_map), node.narrow);
  }
}

void Roadmap::Extend(CandidateTree* tree) const {
  using Entry = std::tuple<double, Cell, int, bool>;  // length, cell, parent node, narrow
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::set<Cell> done;
  for (const CandidateNode& node : tree->nodes) done.insert(CellOf(node.p_map));

  const auto expand = [&](int node) {
    const CandidateNode& from = tree->nodes[static_cast<size_t>(node)];
    const auto place = places_.find(CellOf(from.p_map));
    if (place == places_.end()) return;
    for (const Step& step : place->second.steps) {
      if (done.contains(step.to)) continue;
      const double length_m = (places_.at(step.to).p_map - from.p_map).norm();
      open.emplace(from.path_length_m + length_m, step.to, node, step.narrow);
    }
  };
  const int seeds = static_cast<int>(tree->nodes.size());
  for (int node = 0; node < seeds; ++node) expand(node);
  while (!open.empty()) {
    const auto [length_m, cell, parent, narrow] = open.top();
    open.pop();
    if (!done.insert(cell).second) continue;
    const Place& place = places_.at(cell);
    tree->nodes.push_back({place.p_map, parent, length_m, place.ground_m, narrow});
    expand(static_cast<int>(tree->nodes.size()) - 1);
  }
}

}  // namespace atlas::planner
