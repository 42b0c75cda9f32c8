#include "mapping/terrain/ground_wave.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "mapping/terrain/cell_reading.h"

namespace atlas::mapping::terrain {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kBeside = 5;      ///< cells: ground declared this near to a seen hole is in doubt
constexpr int kHoleRadius = 2;  ///< cells: half side of the square that a hole is told from a grating by
constexpr int kHoleCrossings =
    30;  ///< rays through it, at least: bars that stop one in four would have shown
constexpr int kRaysPerReturn = 10;  ///< of the rays that meet a grating, at most, for one that its bars stop

constexpr float kGentle_m = 0.05f;  ///< from cell to cell: a hull's side is steeper

/// Seeds of another level, at least: a way narrower than half the robot leads nowhere.
constexpr size_t kLeastSeeds = 8;

/// Cells of a level on which a robot fits and which no other has, at least (0.16 m^2): the edge of a step and
/// the underside of a slab are no floors.
constexpr int kLeastNew = 100;

/// Ground that differs by more than a step and noise from ground so many cells beside it is steep.
constexpr int kSteepCells = 2;
constexpr float kSteep = 1.25f;  ///< of a step

/// Ground of this height was linked to, in a cell that the wave holds at another.
struct Seed {
  int row, col;
  float reference_m;
};

/// What most cells come to, gathered in memory order so that the wave, which jumps about, need not open them.
enum class Gist : uint8_t { kEmpty, kAssumed, kSingle, kPlain, kComplex };

class Wave {
 public:
  /// @param crossed  the grid's crossings count for this level.
  Wave(const WaveParams& params, const LayeredGrid& grid, bool crossed, GroundImage* image)
      : params_(params), grid_(grid), crossed_(crossed), image_(*image), nodes_(image->kind.size()) {
    for (int row = 0; row < image_.side; ++row) {
      for (int col = 0; col < image_.side; ++col) Gather(row, col);
    }
    ground_.reserve(nodes_.size());
    other_.reserve(nodes_.size());
  }

  void Reach(int row, int col, float reference) {
    const size_t i = image_.Index(row, col);
    Node& node = nodes_[i];
    if (image_.kind[i] == CellKind::kGround) {
      if (from_walked_) Meet(row, col, reference);
      return;
    }
    const bool first = std::isnan(node.reference_m);
    if (!first && !over_ground_) return;
    const Reading reading = Read(node, row, col, reference);
    if (!first && reading.kind != CellKind::kGround) return;
    if (gently_ && reading.kind == CellKind::kGround && std::abs(reading.height_m - reference) > kGentle_m) {
      steep_.push_back({{row, col, reference}, from_walked_});
      return;
    }
    image_.kind[i] = reading.kind;
    node.reading = reading;
    Walk(row, col, &node);
    node.reference_m = reading.kind == CellKind::kGround ? reading.height_m : reference;
    (reading.kind == CellKind::kGround ? ground_ : other_).push_back({row, col});
  }

  /// Linked ground first, and of it what goes on gently, so that ground beneath a hull is taken before the
  /// hull's side is; then, a cell at a time, across what is not ground.
  void Spread() {
    size_t next_ground = 0, next_steep = 0, next_other = 0;
    while (next_ground < ground_.size() || next_steep < steep_.size() || next_other < other_.size()) {
      over_ground_ = next_ground < ground_.size() || next_steep < steep_.size();
      if (next_ground == ground_.size() && over_ground_) {
        const Steep link = steep_[next_steep++];
        from_walked_ = link.from_walked;
        gently_ = false;
        Reach(link.to.row, link.to.col, link.to.reference_m);
        gently_ = true;
        continue;
      }
      const auto [row, col] = over_ground_ ? ground_[next_ground++] : other_[next_other++];
      const size_t i = image_.Index(row, col);
      if (!over_ground_ && image_.kind[i] == CellKind::kGround) continue;
      const float reference = nodes_[i].reference_m;
      from_walked_ = over_ground_ && nodes_[i].walked;
      if (over_ground_ && nodes_[i].reading.blocked && !crossed_) continue;
      if (col > 0) Reach(row, col - 1, reference);
      if (col + 1 < image_.side) Reach(row, col + 1, reference);
      if (row > 0) Reach(row - 1, col, reference);
      if (row + 1 < image_.side) Reach(row + 1, col, reference);
    }
  }

  /// Where ground at another height may go on.
  const std::vector<Seed>& seeds() const { return seeds_; }
  bool walked(size_t i) const { return nodes_[i].walked; }

  void Publish() const {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      image_.height_m[i] = node.reading.height_m;
      image_.support[i] = node.reading.support;
      image_.blocked[i] = node.reading.blocked;
      image_.reference_m[i] = node.reference_m;
    }
  }

 private:
  struct Place {
    int row, col;
  };
  struct Steep {
    Seed to;
    bool from_walked;
  };
  struct Node {
    Reading reading;
    float reference_m = kNaN;
    float mean_m = kNaN;
    uint16_t count = 0;
    bool walked = false;
    Gist gist = Gist::kEmpty;
  };

  /// Whether feet get to a node as the wave did, or does now: over clear ground, nowhere as steep as the side
  /// of a hull.
  bool Walk(int row, int col, Node* node) const {
    node->walked = from_walked_ && node->reading.kind == CellKind::kGround && !node->reading.blocked &&
                   !IsSteep(row, col, node->reading.height_m);
    return node->walked;
  }
  /// Whether the surface that goes on from a cell rises or falls by more than a step close by.
  bool IsSteep(int row, int col, float height_m) const {
    constexpr int kAside[4][2] = {{-kSteepCells, 0}, {kSteepCells, 0}, {0, -kSteepCells}, {0, kSteepCells}};
    for (const auto& [down, right] : kAside) {
      const int r = row + down, c = col + right;
      if (r < 0 || c < 0 || r >= image_.side || c >= image_.side) continue;
      const Node& beside = nodes_[image_.Index(r, c)];
      if (beside.gist != Gist::kPlain && beside.gist != Gist::kComplex) continue;
      const Reading reading = Read(beside, r, c, height_m);
      if (reading.kind == CellKind::kGround &&
          std::abs(reading.height_m - height_m) > kSteep * params_.step_m)
        return true;
    }
    return false;
  }

  /// Ground at this height, where feet get, is next to a cell that the wave holds already: at another height
  /// it is another floor, if a robot fits between them, or if it is what blocks the lower one (the first
  /// metres of a ramp); at the same, feet get there too.
  void Meet(int row, int col, float reference) {
    Node& node = nodes_[image_.Index(row, col)];
    if (std::abs(reference - node.reference_m) > params_.headroom_m) {
      seeds_.push_back({row, col, reference});
    } else if (node.reading.blocked) {
      const Reading other = Read(node, row, col, reference);
      const bool above = other.height_m - node.reading.height_m > params_.step_m;
      if (above && other.kind == CellKind::kGround) seeds_.push_back({row, col, other.height_m});
    } else if (!node.walked && std::abs(node.reading.height_m - reference) <= params_.link_m &&
               Walk(row, col, &node)) {
      ground_.push_back({row, col});
    }
  }

  void Gather(int row, int col) {
    const size_t i = image_.Index(row, col), slot = grid_.Slot(image_.min_x + col, image_.min_y + row);
    const LayeredCell& cell = grid_.cell(slot);
    const Layer& only = cell.layer[0];
    Node& node = nodes_[i];
    if (crossed_) image_.crossings[i] = grid_.crossings(slot);
    if (only.count == 0) {
      node.mean_m = grid_.assumed_m(slot);
      node.gist = std::isnan(node.mean_m) ? Gist::kEmpty : Gist::kAssumed;
    } else if (cell.layer[1].count == 0 && !IsTall(only)) {
      node.gist = only.count < kMinSupport ? Gist::kSingle : Gist::kPlain;
      node.mean_m = only.mean_m;
      node.count = only.count;
    } else {
      node.gist = Gist::kComplex;
    }
  }

  Reading Read(const Node& node, int row, int col, float reference) const {
    const float apart = std::abs(node.mean_m - reference);
    const bool near = apart <= params_.link_m;
    if (node.gist == Gist::kPlain && near) return {CellKind::kGround, node.mean_m, node.count, false};
    if (node.gist == Gist::kEmpty) return {};
    if (node.gist == Gist::kSingle) {
      return apart <= kSingleReturnGate_m ? Reading{CellKind::kGround, node.mean_m, 1, false} : Reading{};
    }
    if (node.gist == Gist::kAssumed) {
      return near && !HoleNear(row, col, reference) ? Reading{CellKind::kGround, node.mean_m, 0, false}
                                                    : Reading{};
    }
    return ReadCell(params_, grid_.cell(grid_.Slot(image_.min_x + col, image_.min_y + row)), reference);
  }

  /// Declared ground yields to a hole in or beside it. Rays that went down are no proof of one by themselves:
  /// a grating lets through most of those that meet it, and its bars stop the rest at the expected height.
  bool HoleNear(int row, int col, float reference) const {
    for (int r = std::max(0, row - kBeside); r <= std::min(image_.side - 1, row + kBeside); ++r) {
      for (int c = std::max(0, col - kBeside); c <= std::min(image_.side - 1, col + kBeside); ++c) {
        if (image_.crossings[image_.Index(r, c)] > 0 && IsHole(r, c, reference)) return true;
      }
    }
    return false;
  }

  /// Whether many rays went down about this cell and next to none ended at the expected height.
  bool IsHole(int row, int col, float reference) const {
    int crossings = 0, returns = 0;
    for (int r = std::max(0, row - kHoleRadius); r <= std::min(image_.side - 1, row + kHoleRadius); ++r) {
      for (int c = std::max(0, col - kHoleRadius); c <= std::min(image_.side - 1, col + kHoleRadius); ++c) {
        const size_t i = image_.Index(r, c);
        crossings += image_.crossings[i];
        returns += ReturnsNear(nodes_[i], r, c, reference);
      }
    }
    return crossings >= kHoleCrossings && returns * kRaysPerReturn < crossings;
  }

  int ReturnsNear(const Node& node, int row, int col, float reference) const {
    if (node.gist != Gist::kComplex) {
      return std::abs(node.mean_m - reference) <= kSingleReturnGate_m ? node.count : 0;
    }
    int returns = 0;
    for (const Layer& layer : grid_.cell(grid_.Slot(image_.min_x + col, image_.min_y + row)).layer) {
      if (layer.count > 0 && std::abs(SurfaceOf(layer) - reference) <= kSingleReturnGate_m)
        returns += layer.count;
    }
    return returns;
  }

  const WaveParams& params_;
  const LayeredGrid& grid_;
  const bool crossed_;
  GroundImage& image_;
  std::vector<Node> nodes_;
  std::vector<Place> ground_, other_;
  std::vector<Steep> steep_;
  std::vector<Seed> seeds_;
  bool over_ground_ = true;
  bool gently_ = true;  ///< steep links wait
  /// Another floor is where a robot gets: not along the underside of a slab, nor over a hull.
  bool from_walked_ = true;
};

GroundImage EmptyImage(const GroundImage& where) {
  GroundImage image;
  image.min_x = where.min_x;
  image.min_y = where.min_y;
  image.side = where.side;
  const size_t count = static_cast<size_t>(image.side) * static_cast<size_t>(image.side);
  image.kind.assign(count, CellKind::kUnseen);
  image.height_m.assign(count, kNaN);
  image.reference_m.assign(count, kNaN);
  image.support.assign(count, 0);
  image.crossings.assign(count, 0);
  image.blocked.assign(count, 0);
  return image;
}

/// The levels found so far, and where others may begin.
class LevelSearch {
 public:
  LevelSearch(const WaveParams& params, const GroundImage& where, const LayeredGrid& grid)
      : params_(params), where_(where), grid_(grid) {}

  void AddRobotsLevel(const WaveStart& start) {
    levels_.push_back(EmptyImage(where_));
    Wave wave(params_, grid_, true, &levels_.back());
    const int reach = std::max(1, static_cast<int>(start.seed_radius_m / grid_.cell_m()));
    const int row = grid_.IndexOf(start.robot.y()) - where_.min_y,
              col = grid_.IndexOf(start.robot.x()) - where_.min_x;
    for (int r = std::max(0, row - reach); r <= std::min(where_.side - 1, row + reach); ++r) {
      for (int c = std::max(0, col - reach); c <= std::min(where_.side - 1, col + reach); ++c) {
        wave.Reach(r, c, start.ground_m);
      }
    }
    Finish(&wave);
    Keep(wave.seeds());
  }

  /// From the first seeds that belong to no level yet; false where there are none.
  bool AddOther() {
    std::erase_if(seeds_, [&](const Seed& seed) { return !Leads(seed); });
    while (!seeds_.empty()) {
      std::vector<Seed> from;
      const float height = seeds_.front().reference_m;
      std::erase_if(seeds_, [&](const Seed& seed) {
        if (std::abs(seed.reference_m - height) > params_.headroom_m) return false;
        from.push_back(seed);
        return true;
      });
      std::set<size_t> cells;
      for (const Seed& seed : from) cells.insert(where_.Index(seed.row, seed.col));
      if (cells.size() < kLeastSeeds) continue;
      levels_.push_back(EmptyImage(where_));
      Wave wave(params_, grid_, false, &levels_.back());
      for (const Seed& seed : from) wave.Reach(seed.row, seed.col, seed.reference_m);
      Finish(&wave);
      if (HoldsNewGround(wave)) {
        Keep(wave.seeds());
        return true;
      }
      levels_.pop_back();
    }
    return false;
  }

  std::vector<GroundImage> Levels() && { return std::move(levels_); }
  size_t count() const { return levels_.size(); }

 private:
  /// To ground that no level holds.
  bool Leads(const Seed& seed) const {
    const LayeredCell& cell = grid_.cell(grid_.Slot(where_.min_x + seed.col, where_.min_y + seed.row));
    const Layer* surface = FindSurface(params_, cell, seed.reference_m);
    if (surface == nullptr || ReadGround(params_, cell, *surface).blocked) return false;
    const size_t i = where_.Index(seed.row, seed.col);
    return std::none_of(levels_.begin(), levels_.end(), [&](const GroundImage& level) {
      return level.kind[i] == CellKind::kGround &&
             std::abs(level.height_m[i] - seed.reference_m) <= params_.step_m;
    });
  }
  /// The latest level, of that wave: ground that no level before it has, and that can be walked on.
  bool HoldsNewGround(const Wave& wave) const {
    const GroundImage& latest = levels_.back();
    const auto holds = [&](const GroundImage& other, size_t i) {
      return other.kind[i] == CellKind::kGround &&
             std::abs(other.height_m[i] - latest.height_m[i]) <= params_.step_m;
    };
    int cells = 0;
    for (size_t i = 0; i < latest.kind.size() && cells < kLeastNew; ++i) {
      if (!wave.walked(i)) continue;
      cells += std::none_of(levels_.begin(), levels_.end() - 1,
                            [&](const GroundImage& other) { return holds(other, i); });
    }
    return cells >= kLeastNew;
  }
  static void Finish(Wave* wave) {
    wave->Spread();
    wave->Publish();
  }
  void Keep(const std::vector<Seed>& seeds) { seeds_.insert(seeds_.end(), seeds.begin(), seeds.end()); }

  const WaveParams& params_;
  const GroundImage& where_;
  const LayeredGrid& grid_;
  std::vector<GroundImage> levels_;
  std::vector<Seed> seeds_;
};

/// Rays that crossed one floor are no evidence against another.
void ExpectGround(const GroundImage& level, float headroom_m, LayeredGrid* grid) {
  for (int r = 0; r < level.side; ++r) {
    for (int c = 0; c < level.side; ++c) {
      const size_t slot = grid->Slot(level.min_x + c, level.min_y + r);
      const float reference = level.reference_m[level.Index(r, c)];
      if (std::abs(grid->reference_m(slot) - reference) > headroom_m) grid->ForgetCrossings(slot);
      grid->SetReference(slot, reference);
    }
  }
}

}  // namespace

std::vector<GroundImage> FindLevels(const WaveParams& params, const WaveStart& start,
                                    const GroundImage& where, LayeredGrid* grid) {
  LevelSearch search(params, where, *grid);
  search.AddRobotsLevel(start);
  while (search.count() < static_cast<size_t>(kMostLevels) && search.AddOther()) {
  }
  std::vector<GroundImage> levels = std::move(search).Levels();
  ExpectGround(levels.front(), params.headroom_m, grid);
  return levels;
}

}  // namespace atlas::mapping::terrain
