#include "mapping/terrain/ground_wave.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace atlas::mapping::terrain {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr uint16_t kMinSupport = 2;           ///< a single return may be noise ...
constexpr float kSingleReturnGate_m = 0.06f;  ///< ... unless it lies where ground is expected

bool IsTall(const Layer& layer) {
  return layer.hi_m - layer.lo_m > kTall_m;
}
float SurfaceOf(const Layer& layer) {
  return IsTall(layer) ? layer.lo_m : layer.mean_m;
}

struct Reading {
  CellKind kind = CellKind::kUnseen;
  float height_m = kNaN;
  uint16_t support = 0;
  bool blocked = false;
};

/// The highest well supported surface up to a step above `reference`; else the nearest within the link.
const Layer* FindSurface(const WaveParams& params, const LayeredCell& cell, float reference) {
  uint16_t strongest = 0;
  for (const Layer& layer : cell.layer) {
    if (layer.count > strongest && std::abs(SurfaceOf(layer) - reference) <= params.link_m)
      strongest = layer.count;
  }
  if (strongest == 0) return nullptr;
  const Layer* highest = nullptr;
  const Layer* nearest = nullptr;
  for (const Layer& layer : cell.layer) {
    const float above = SurfaceOf(layer) - reference;
    const bool single = layer.count == 1 && std::abs(above) <= kSingleReturnGate_m && strongest == 1;
    if (layer.count == 0 || std::abs(above) > params.link_m || (layer.count < kMinSupport && !single))
      continue;
    if (above <= params.step_m && layer.count * 4 >= strongest &&
        (highest == nullptr || SurfaceOf(layer) > SurfaceOf(*highest))) {
      highest = &layer;
    }
    if (nearest == nullptr || std::abs(above) < std::abs(SurfaceOf(*nearest) - reference)) nearest = &layer;
  }
  return highest != nullptr ? highest : nearest;
}

Reading ReadGround(const WaveParams& params, const LayeredCell& cell, const Layer& surface) {
  Reading reading{CellKind::kGround, SurfaceOf(surface), surface.count, false};
  const float low = reading.height_m + params.step_m, high = reading.height_m + params.headroom_m;
  for (const Layer& layer : cell.layer) {
    if (layer.count < kMinSupport || (&layer == &surface && !IsTall(layer))) continue;
    if (layer.hi_m > low && layer.lo_m < high) reading.blocked = true;
  }
  return reading;
}

/// A cell without ground: something in the way, a floor far below, or nothing.
Reading ReadOther(const WaveParams& params, const LayeredCell& cell, float reference) {
  Reading reading;
  for (const Layer& layer : cell.layer) {
    if (layer.count < kMinSupport) continue;
    const bool in_the_way =
        layer.hi_m > reference + params.link_m && layer.lo_m < reference + params.headroom_m;
    if (in_the_way && (reading.kind != CellKind::kObstacle || layer.hi_m < reading.height_m)) {
      reading = {CellKind::kObstacle, layer.hi_m, layer.count, true};
    } else if (reading.kind != CellKind::kObstacle && layer.hi_m < reference - params.link_m &&
               (reading.kind == CellKind::kUnseen || layer.mean_m > reading.height_m)) {
      reading = {CellKind::kBelow, layer.mean_m, 0, false};
    }
  }
  return reading;
}

Reading ReadCell(const WaveParams& params, const LayeredCell& cell, float reference) {
  if (const Layer* surface = FindSurface(params, cell, reference)) return ReadGround(params, cell, *surface);
  return ReadOther(params, cell, reference);
}

constexpr int kBeside = 5;      ///< cells: ground declared this near to a seen hole is in doubt
constexpr int kHoleRadius = 2;  ///< cells: half side of the square that a hole is told from a grating by
constexpr int kHoleCrossings =
    30;  ///< rays through it, at least: bars that stop one in four would have shown
constexpr int kRaysPerReturn = 10;  ///< of the rays that meet a grating, at most, for one that its bars stop

/// Seeds of another level, at least: a way narrower than half the robot leads nowhere.
constexpr size_t kLeastSeeds = 8;

/// Cells of a level on which a robot fits and which no other has, at least (0.16 m^2): the edge of a step and
/// the underside of a slab are no floors.
constexpr int kLeastNew = 100;

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
      if (from_clear_ && IsOther(node, reference)) seeds_.push_back({row, col, reference});
      return;
    }
    const bool first = std::isnan(node.reference_m);
    if (!first && !over_ground_) return;
    const Reading reading = Read(node, row, col, reference);
    if (!first && reading.kind != CellKind::kGround) return;
    image_.kind[i] = reading.kind;
    node.reading = reading;
    node.reference_m = reading.kind == CellKind::kGround ? reading.height_m : reference;
    (reading.kind == CellKind::kGround ? ground_ : other_).push_back({row, col});
  }

  /// Linked ground first; then, a cell at a time, across what is not ground.
  void Spread() {
    size_t next_ground = 0, next_other = 0;
    while (next_ground < ground_.size() || next_other < other_.size()) {
      over_ground_ = next_ground < ground_.size();
      const auto [row, col] = over_ground_ ? ground_[next_ground++] : other_[next_other++];
      const size_t i = image_.Index(row, col);
      if (!over_ground_ && image_.kind[i] == CellKind::kGround) continue;
      const float reference = nodes_[i].reference_m;
      from_clear_ = over_ground_ && !nodes_[i].reading.blocked;
      if (over_ground_ && !from_clear_ && !crossed_) continue;
      if (col > 0) Reach(row, col - 1, reference);
      if (col + 1 < image_.side) Reach(row, col + 1, reference);
      if (row > 0) Reach(row - 1, col, reference);
      if (row + 1 < image_.side) Reach(row + 1, col, reference);
    }
  }

  /// Where ground at another height may go on.
  const std::vector<Seed>& seeds() const { return seeds_; }

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
  struct Node {
    Reading reading;
    float reference_m = kNaN;
    float mean_m = kNaN;
    uint16_t count = 0;
    Gist gist = Gist::kEmpty;
  };

  /// Whether ground linked at this height is another floor than what the cell holds: a robot fits between
  /// them, or it is what blocks the lower one (the first metres of a ramp).
  bool IsOther(const Node& node, float reference) const {
    const float above = reference - node.reference_m;
    return std::abs(above) > params_.headroom_m || (above > params_.step_m && node.reading.blocked);
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
  std::vector<Seed> seeds_;
  bool over_ground_ = true;
  bool from_clear_ = false;  ///< another floor is where a robot fits: none leads along a slab's underside
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
      if (HoldsNewGround()) {
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
  /// The latest level: ground that no level before it has.
  bool HoldsNewGround() const {
    const GroundImage& latest = levels_.back();
    const auto holds = [&](const GroundImage& other, size_t i) {
      return other.kind[i] == CellKind::kGround &&
             std::abs(other.height_m[i] - latest.height_m[i]) <= params_.step_m;
    };
    int cells = 0;
    for (size_t i = 0; i < latest.kind.size() && cells < kLeastNew; ++i) {
      if (latest.kind[i] != CellKind::kGround || latest.blocked[i]) continue;
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
