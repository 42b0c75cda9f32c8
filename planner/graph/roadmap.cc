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

bool Roadmap::SameFloor(double a_m, double b_m) {
  return std::abs(a_m - b_m) <= mapping::TraversableGround::kSameLevel_m;
}

size_t Roadmap::PlaceAt(const Vec2& p_map, double ground_m) const {
  const auto cell = at_.find(CellOf(p_map));
  if (cell == at_.end()) return kNone;
  for (const size_t place : cell->second) {
    if (SameFloor(places_[place].ground_m, ground_m)) return place;
  }
  return kNone;
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
    const size_t oldest = PlaceAt(places_[i].p_map, places_[i].ground_m);
    if (oldest == kNone) {
      at_[CellOf(places_[i].p_map)].push_back(i);
    } else {
      Join(oldest, i, false);
    }
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
      for (const size_t other : near->second) {
        const bool same_floor = SameFloor(places_[other].ground_m, places_[place].ground_m);
        if (same_floor && (places_[other].p_map - places_[place].p_map).norm() <= kNear_m) {
          Join(other, place, false);
        }
      }
    }
  }
}

void Roadmap::Learn(const CandidateTree& tree, const core::PoseSource& poses) {
  Correct(poses);
  const size_t known = places_.size();
  for (const CandidateNode& node : tree.nodes) {
    size_t at = PlaceAt(node.p_map, node.ground_m);
    if (at == kNone) {
      at = places_.size();
      at_[CellOf(node.p_map)].push_back(at);
      places_.emplace_back();
    }
    Place& place = places_[at];
    place.anchor = core::AnchoredPoint::At(node.place(), poses);
    place.p_map = node.p_map;
    place.ground_m = node.ground_m;
  }
  if (corrected_) {
    for (size_t i = known; i < places_.size(); ++i) JoinToNear(i);
  }
  for (const CandidateNode& node : tree.nodes) {
    if (node.parent < 0) continue;
    const CandidateNode& parent = tree.nodes[static_cast<size_t>(node.parent)];
    Join(PlaceAt(node.p_map, node.ground_m), PlaceAt(parent.p_map, parent.ground_m), node.narrow);
  }
}

void Roadmap::Extend(CandidateTree* tree) const {
  using Entry = std::tuple<double, Cell, int, bool, size_t>;  // length, cell, parent node, narrow, place
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::set<size_t> done;
  for (const CandidateNode& node : tree->nodes) {
    if (const size_t at = PlaceAt(node.p_map, node.ground_m); at != kNone) done.insert(at);
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
    const CandidateNode& seed = tree->nodes[static_cast<size_t>(node)];
    if (const size_t at = PlaceAt(seed.p_map, seed.ground_m); at != kNone) expand(node, at);
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
