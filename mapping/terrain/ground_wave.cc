#include "mapping/terrain/ground_wave.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// What most cells come to, gathered in memory order so that the wave, which jumps about, need not open them.
enum class Gist : uint8_t { kEmpty, kAssumed, kSingle, kPlain, kComplex };

class Wave {
 public:
  Wave(const WaveParams& params, const LayeredGrid& grid, GroundImage* image)
      : params_(params), grid_(grid), image_(*image), nodes_(image->kind.size()) {
    for (int row = 0; row < image_.side; ++row) {
      for (int col = 0; col < image_.side; ++col) Gather(row, col);
    }
    ground_.reserve(nodes_.size());
    other_.reserve(nodes_.size());
  }

  void Reach(int row, int col, float reference) {
    const size_t i = image_.Index(row, col);
    if (image_.kind[i] == CellKind::kGround) return;
    Node& node = nodes_[i];
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
      if (col > 0) Reach(row, col - 1, reference);
      if (col + 1 < image_.side) Reach(row, col + 1, reference);
      if (row > 0) Reach(row - 1, col, reference);
      if (row + 1 < image_.side) Reach(row + 1, col, reference);
    }
  }

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

  void Gather(int row, int col) {
    const size_t i = image_.Index(row, col), slot = grid_.Slot(image_.min_x + col, image_.min_y + row);
    const LayeredCell& cell = grid_.cell(slot);
    const Layer& only = cell.layer[0];
    Node& node = nodes_[i];
    image_.crossings[i] = grid_.crossings(slot);
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
  GroundImage& image_;
  std::vector<Node> nodes_;
  std::vector<Place> ground_, other_;
  bool over_ground_ = true;
};

}  // namespace

void FindGround(const WaveParams& params, const core::Vec2& robot, double seed_radius_m, float ground_m,
                LayeredGrid* grid, GroundImage* image) {
  const size_t count = static_cast<size_t>(image->side) * static_cast<size_t>(image->side);
  image->kind.assign(count, CellKind::kUnseen);
  image->height_m.assign(count, kNaN);
  image->reference_m.assign(count, kNaN);
  image->support.assign(count, 0);
  image->crossings.assign(count, 0);
  image->blocked.assign(count, 0);
  Wave wave(params, *grid, image);
  const int reach = std::max(1, static_cast<int>(seed_radius_m / grid->cell_m()));
  const int row = grid->IndexOf(robot.y()) - image->min_y, col = grid->IndexOf(robot.x()) - image->min_x;
  for (int r = std::max(0, row - reach); r <= std::min(image->side - 1, row + reach); ++r) {
    for (int c = std::max(0, col - reach); c <= std::min(image->side - 1, col + reach); ++c) {
      wave.Reach(r, c, ground_m);
    }
  }
  wave.Spread();
  wave.Publish();
  for (int r = 0; r < image->side; ++r) {
    for (int c = 0; c < image->side; ++c) {
      grid->SetReference(grid->Slot(image->min_x + c, image->min_y + r),
                         image->reference_m[image->Index(r, c)]);
    }
  }
}

}  // namespace atlas::mapping::terrain
