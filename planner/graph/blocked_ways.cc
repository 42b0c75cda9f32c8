// The widest way by Dijkstra over cells, where the cost of a way is its least clearance:
//
//     #########  beyond
//   A  . . . . n . . . b        A: ground that the candidates cover
//     #########                 n: the narrowest place on the way to b
#include "planner/graph/blocked_ways.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

#include "mapping/terrain/grid_filters.h"

namespace atlas::planner {
namespace {

using core::Vec2;

constexpr double kCell_m = 0.05;
constexpr double kSamePlace_m = 0.6;        ///< narrow places nearer to each other are one
constexpr double kBeyond_m = 0.75;          ///< ground this near to covered ground is seen as well from there
constexpr double kLeastClearance_m = 0.12;  ///< narrower gaps than twice this lead nowhere
constexpr double kSpacing_m = 0.5;          ///< of the places beyond
constexpr int kPlaces = 8;                  ///< beyond one narrow place, at most
constexpr double kAcross_rad = core::Radians(110.0);  ///< what flanks a way lies on both sides of it

/// The window as cells: which are free, and how far from what is not.
class CellGrid {
 public:
  CellGrid(const mapping::TraversableGround& ground, double reach_m)
      : min_(ground.Window().min.head<2>()), reach_(static_cast<int>(std::ceil(reach_m / kCell_m))) {
    const core::Vec3 size = ground.Window().Size();
    cols_ = std::max(1, static_cast<int>(size.x() / kCell_m));
    rows_ = std::max(1, static_cast<int>(size.y() / kCell_m));
    kind_.resize(static_cast<size_t>(cols_) * static_cast<size_t>(rows_));
    mapping::terrain::Mask blocked(kind_.size());
    for (int i = 0; i < count(); ++i) {
      kind_[At(i)] = ground.KindAt(ground.OnRobotsLevel(CenterOf(i), 0.0));
      blocked[At(i)] = kind_[At(i)] != mapping::GroundKind::kFree;
    }
    distance2_ = mapping::terrain::SquaredDistance(blocked, rows_, cols_, reach_);
  }

  int count() const { return static_cast<int>(kind_.size()); }
  int cols() const { return cols_; }
  int rows() const { return rows_; }
  Vec2 CenterOf(int i) const { return min_ + kCell_m * Vec2(i % cols_ + 0.5, i / cols_ + 0.5); }
  int CellOf(const Vec2& p) const {
    const int col = static_cast<int>(std::floor((p.x() - min_.x()) / kCell_m)),
              row = static_cast<int>(std::floor((p.y() - min_.y()) / kCell_m));
    return col < 0 || row < 0 || col >= cols_ || row >= rows_ ? -1 : row * cols_ + col;
  }
  mapping::GroundKind kind(int i) const { return kind_[At(i)]; }
  double clearance_m(int i) const { return kCell_m * std::sqrt(distance2_[At(i)]); }

  /// Calls visit(j) for the cells within `radius_m` of `p`.
  template <typename Visit>
  void ForDisc(const Vec2& p, double radius_m, const Visit& visit) const {
    const int reach = static_cast<int>(radius_m / kCell_m);
    for (int dr = -reach; dr <= reach; ++dr) {
      for (int dc = -reach; dc <= reach; ++dc) {
        const int j = dr * dr + dc * dc <= reach * reach ? CellOf(p + kCell_m * Vec2(dc, dr)) : -1;
        if (j >= 0) visit(j);
      }
    }
  }

 private:
  static size_t At(int i) { return static_cast<size_t>(i); }

  Vec2 min_;
  int reach_, rows_ = 0, cols_ = 0;
  std::vector<mapping::GroundKind> kind_;
  std::vector<int16_t> distance2_;
};

bool OnRobotsLevel(const mapping::TraversableGround& ground, const core::Vec3& place) {
  const double apart = ground.OnRobotsLevel(place.head<2>(), place.z()).z() - place.z();
  return std::abs(apart) <= mapping::TraversableGround::kSameLevel_m;
}

/// Cells where the robot can stand that are joined to a place of the tree or to the robot.
std::vector<uint8_t> Covered(const CellGrid& grid, const Walkable& walkable, const CandidateTree& tree) {
  std::vector<uint8_t> covered(static_cast<size_t>(grid.count()), 0), asked = covered;
  std::vector<int> open;
  const auto reach = [&](int i) {
    if (i < 0 || covered[static_cast<size_t>(i)]) return;
    covered[static_cast<size_t>(i)] = 1;
    open.push_back(i);
  };
  reach(grid.CellOf(walkable.start().head<2>()));
  for (const CandidateNode& node : tree.nodes) {
    if (OnRobotsLevel(walkable.ground(), node.place())) reach(grid.CellOf(node.p_map));
  }
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    const int row = i / grid.cols(), col = i % grid.cols();
    const auto step = [&](int j) {
      if (covered[static_cast<size_t>(j)] || std::exchange(asked[static_cast<size_t>(j)], 1)) return;
      if (walkable.ground().CircleFree(walkable.ground().OnRobotsLevel(grid.CenterOf(j), 0.0))) reach(j);
    };
    if (col > 0) step(i - 1);
    if (col + 1 < grid.cols()) step(i + 1);
    if (row > 0) step(i - grid.cols());
    if (row + 1 < grid.rows()) step(i + grid.cols());
  }
  return covered;
}

/// Of each cell, the narrowest cell on the widest way to it; -1 where no free ground leads.
struct WidestWays {
  std::vector<int> narrowest;
  std::vector<double> least_m;  ///< clearance there

  WidestWays(const CellGrid& grid, const std::vector<uint8_t>& covered)
      : narrowest(covered.size(), -1), least_m(covered.size(), 0.0) {
    using Entry = std::tuple<double, double, int, int>;  // least clearance, -length, cell, narrowest
    std::priority_queue<Entry> open;
    for (int i = 0; i < grid.count(); ++i) {
      if (covered[static_cast<size_t>(i)]) open.emplace(1e3, 0.0, i, i);
    }
    while (!open.empty()) {
      const auto [least, length, i, at] = open.top();
      open.pop();
      if (narrowest[static_cast<size_t>(i)] >= 0) continue;
      narrowest[static_cast<size_t>(i)] = at;
      least_m[static_cast<size_t>(i)] = least;
      for (int k = 0; k < 9; ++k) {
        const int col = i % grid.cols() + k % 3 - 1, row = i / grid.cols() + k / 3 - 1;
        if (k == 4 || col < 0 || row < 0 || col >= grid.cols() || row >= grid.rows()) continue;
        const int j = row * grid.cols() + col;
        if (narrowest[static_cast<size_t>(j)] >= 0 || grid.kind(j) != mapping::GroundKind::kFree) continue;
        const double clearance = grid.clearance_m(j);
        // In a corridor that is equally wide all along, its beginning counts.
        const bool narrower =
            covered[static_cast<size_t>(at)] || clearance < grid.clearance_m(at) - 0.5 * kCell_m;
        open.emplace(std::min(least, clearance), length - (k % 2 == 1 ? 1.0 : 1.4142), j, narrower ? j : at);
      }
    }
  }
};

/// What stands on both sides of a narrow place.
struct Flanks {
  Vec2 a, b;
  mapping::GroundKind kind_a, kind_b;
};

/// The nearest cell that is not free, and the nearest on the other side of `p`; nothing where either was
/// never seen, or the other side is farther than `reach_m`.
std::optional<Flanks> FlanksOf(const CellGrid& grid, const Vec2& p, double reach_m) {
  int nearest = -1, across = -1;
  const auto distance = [&](int j) { return (grid.CenterOf(j) - p).norm(); };
  grid.ForDisc(p, reach_m, [&](int j) {
    if (grid.kind(j) != mapping::GroundKind::kFree && (nearest < 0 || distance(j) < distance(nearest)))
      nearest = j;
  });
  if (nearest < 0) return std::nullopt;
  const Vec2 to = grid.CenterOf(nearest) - p;
  grid.ForDisc(p, reach_m, [&](int j) {
    const Vec2 other = grid.CenterOf(j) - p;
    const bool opposite = other.dot(to) < std::cos(kAcross_rad) * other.norm() * to.norm();
    if (grid.kind(j) != mapping::GroundKind::kFree && opposite &&
        (across < 0 || distance(j) < distance(across)))
      across = j;
  });
  if (across < 0) return std::nullopt;
  return Flanks{grid.CenterOf(nearest), grid.CenterOf(across), grid.kind(nearest), grid.kind(across)};
}

class Search {
 public:
  Search(const Walkable& walkable, const CandidateTree& tree, const Footprint& footprint)
      : walkable_(walkable),
        footprint_(footprint),
        grid_(walkable.ground(), footprint.turning_radius_m + 0.3),
        covered_(Covered(grid_, walkable, tree)) {}

  std::vector<BlockedWay> Run() const {
    std::vector<BlockedWay> found;
    const std::vector<Vec2> beyond = PlacesBeyond();
    if (beyond.empty()) return found;
    const WidestWays ways(grid_, covered_);
    for (const Vec2& place : beyond) {
      const auto i = static_cast<size_t>(grid_.CellOf(place));
      const bool linked = ways.narrowest[i] >= 0 && ways.least_m[i] >= kLeastClearance_m;
      if (!linked || ways.least_m[i] >= footprint_.turning_radius_m) continue;
      const auto way = WayThrough(grid_.CenterOf(ways.narrowest[i]));
      if (way) Add(*way, place, &found);
    }
    for (BlockedWay& way : found) Thin(&way);
    return found;
  }

 private:
  /// Free places of a lattice that are not beside covered ground.
  std::vector<Vec2> PlacesBeyond() const {
    std::vector<uint8_t> near(covered_.size(), 0);
    mapping::terrain::Mask mask(covered_.begin(), covered_.end());
    const int reach = static_cast<int>(kBeyond_m / kCell_m);
    const std::vector<int16_t> d2 =
        mapping::terrain::SquaredDistance(mask, grid_.rows(), grid_.cols(), reach);
    std::vector<Vec2> places;
    const core::Box3& window = walkable_.ground().Window();
    for (double y = std::ceil(window.min.y() / kSpacing_m) * kSpacing_m; y < window.max.y();
         y += kSpacing_m) {
      for (double x = std::ceil(window.min.x() / kSpacing_m) * kSpacing_m; x < window.max.x();
           x += kSpacing_m) {
        const int i = grid_.CellOf({x, y});
        if (i < 0 || grid_.kind(i) != mapping::GroundKind::kFree ||
            d2[static_cast<size_t>(i)] <= reach * reach)
          continue;
        if (grid_.clearance_m(i) >= kLeastClearance_m) places.push_back(WidestNear(grid_.CenterOf(i)));
      }
    }
    return places;
  }

  /// The middle of a corridor, not a place at its wall, whose own clearance would be the narrowest of its
  /// way.
  Vec2 WidestNear(const Vec2& p) const {
    int widest = grid_.CellOf(p);
    grid_.ForDisc(p, 0.75 * kSpacing_m, [&](int j) {
      if (grid_.kind(j) == mapping::GroundKind::kFree && grid_.clearance_m(j) > grid_.clearance_m(widest))
        widest = j;
    });
    return grid_.CenterOf(widest);
  }

  std::optional<BlockedWay> WayThrough(const Vec2& narrowest) const {
    const double turning_m = 2.0 * footprint_.turning_radius_m, across_m = 2.0 * footprint_.half_width_m;
    const auto flanks = FlanksOf(grid_, narrowest, turning_m);
    if (!flanks || flanks->kind_a == mapping::GroundKind::kUnknown ||
        flanks->kind_b == mapping::GroundKind::kUnknown)
      return std::nullopt;
    // From a drop the robot keeps clear besides.
    double rim_m = 0.0;
    for (const mapping::GroundKind kind : {flanks->kind_a, flanks->kind_b}) {
      rim_m += kind == mapping::GroundKind::kDrop ? footprint_.edge_clearance_m : 0.0;
    }
    BlockedWay way;
    way.p_map = 0.5 * (flanks->a + flanks->b);
    way.width_m = std::max(0.0, (flanks->a - flanks->b).norm() - kCell_m);
    way.needed_m = rim_m + (way.width_m < across_m + rim_m ? across_m : turning_m);
    if (way.width_m >= way.needed_m) return std::nullopt;
    return way;
  }

  void Add(const BlockedWay& way, const Vec2& place, std::vector<BlockedWay>* found) const {
    const auto same = std::find_if(found->begin(), found->end(), [&](const BlockedWay& other) {
      return (other.p_map - way.p_map).norm() < kSamePlace_m;
    });
    BlockedWay& into = same == found->end() ? found->emplace_back(way) : *same;
    const double ground_m =
        walkable_.ground().SurfaceAt(walkable_.ground().OnRobotsLevel(place, 0.0)).height_m;
    into.beyond_map.emplace_back(place.x(), place.y(), ground_m);
  }

  /// Keeps a few places that are spread out.
  void Thin(BlockedWay* way) const {
    std::vector<CandidateNode> nodes;
    for (const core::Vec3& p : way->beyond_map) nodes.push_back({.p_map = p.head<2>(), .ground_m = p.z()});
    std::vector<core::Vec3> kept;
    for (const int i : SpreadOut(nodes, way->p_map, kPlaces)) {
      kept.push_back(way->beyond_map[static_cast<size_t>(i)]);
    }
    way->beyond_map = std::move(kept);
  }

  const Walkable& walkable_;
  Footprint footprint_;
  CellGrid grid_;
  std::vector<uint8_t> covered_;
};

}  // namespace

std::vector<BlockedWay> FindBlockedWays(const Walkable& walkable, const CandidateTree& tree,
                                        const Footprint& footprint) {
  return Search(walkable, tree, footprint).Run();
}

BlockedWays::Known BlockedWays::Anchored(const BlockedWay& way, const core::PoseSource& poses) {
  const auto anchored = [&](const core::Vec3& p) { return Place{core::AnchoredPoint::At(p, poses), p}; };
  Known known{way, anchored({way.p_map.x(), way.p_map.y(), way.beyond_map.front().z()}), {}};
  for (const core::Vec3& p : way.beyond_map) known.beyond.push_back(anchored(p));
  return known;
}

void BlockedWays::Correct(const core::PoseSource& poses) {
  if (poses.version() == version_) return;
  version_ = poses.version();
  for (Known& known : known_) {
    known.middle.p_map = known.middle.anchor.p_map(poses);
    for (Place& place : known.beyond) place.p_map = place.anchor.p_map(poses);
  }
}

void BlockedWays::Learn(const Walkable& walkable, const CandidateTree& tree,
                        const std::vector<BlockedWay>& found, const core::PoseSource& poses) {
  Correct(poses);
  const core::Box3& window = walkable.ground().Window();
  const auto in_window = [&](const core::Vec3& p) {
    return window.Contains(core::Vec3(p.x(), p.y(), window.Center().z())) &&
           OnRobotsLevel(walkable.ground(), p);
  };
  const auto reached = [&](const core::Vec3& p) {
    return std::any_of(tree.nodes.begin(), tree.nodes.end(), [&](const CandidateNode& node) {
      return (node.p_map - p.head<2>()).norm() < kBeyond_m &&
             std::abs(node.ground_m - p.z()) <= mapping::TraversableGround::kSameLevel_m;
    });
  };
  for (Known& known : known_) {
    std::erase_if(known.beyond,
                  [&](const Place& place) { return in_window(place.p_map) || reached(place.p_map); });
  }
  std::erase_if(known_, [](const Known& known) { return known.beyond.empty(); });
  for (const BlockedWay& way : found) Add(Anchored(way, poses));
}

void BlockedWays::Add(Known way) {
  const auto same = std::find_if(known_.begin(), known_.end(), [&](const Known& other) {
    return (other.middle.p_map - way.middle.p_map).head<2>().norm() < kSamePlace_m;
  });
  if (same == known_.end()) {
    known_.push_back(std::move(way));
  } else {
    way.beyond.insert(way.beyond.end(), same->beyond.begin(), same->beyond.end());
    *same = std::move(way);
  }
}

std::vector<BlockedWay> BlockedWays::ways() const {
  std::vector<BlockedWay> ways;
  for (const Known& known : known_) {
    BlockedWay& way = ways.emplace_back(known.way);
    way.p_map = known.middle.p_map.head<2>();
    way.beyond_map.clear();
    for (const Place& place : known.beyond) way.beyond_map.push_back(place.p_map);
  }
  return ways;
}

std::vector<core::Vec3> BlockedWays::PlacesBeyond() const {
  std::vector<core::Vec3> places;
  for (const Known& known : known_) {
    for (const Place& place : known.beyond) places.push_back(place.p_map);
  }
  return places;
}

void BlockedWays::SetWorth(const std::vector<double>& shares, double least) {
  size_t next = 0;
  for (Known& known : known_) {
    double best = 0.0;
    for (size_t k = 0; k < known.beyond.size(); ++k) best = std::max(best, shares[next++]);
    known.way.worth_share = best;
    known.way.promises = best >= least;
  }
}

}  // namespace atlas::planner
