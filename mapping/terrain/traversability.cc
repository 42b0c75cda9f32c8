#include "mapping/terrain/traversability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mapping/terrain/gap_filling.h"

namespace atlas::mapping::terrain {
namespace {

constexpr double kPlaneRadius_m = 0.26;  ///< half side of the square that slope and roughness are fitted over
constexpr int kStepRadius = 2;           ///< cells
constexpr float kRiser_m = 0.06;         ///< neighbouring cells that differ by more are the edge of a step
constexpr double kRidgeWidth_m = 0.25;   ///< what is narrower is no place for feet ...
constexpr float kRidge_m = 0.06;  ///< ... and trips them where it stands out by more: a tube, a curb stone
/// Cells before an edge that may hold returns of its riser: noise of a centimetre along the ray carries them
/// up to 3 cm (3 sigma) off an upright face, which may stand anywhere in its own cell.
constexpr int kRiserSpread = 2;
constexpr int kDropCrossings = 3;  ///< rays that went down, at least; fewer may be noise
constexpr int kRim2 = 2;           ///< squared cells: so near to an open cell nothing is traversable
constexpr float kSlopeWeight = 0.4f, kStepWeight = 0.3f, kRoughnessWeight = 0.3f;

/// The limits of TerrainParams as the filters' outputs are compared with them.
struct Limits {
  explicit Limits(const TerrainParams& params)
      : slope_rad(static_cast<float>(core::Radians(params.critical_slope_deg))),
        step_m(static_cast<float>(params.critical_step_m)),
        roughness_m(static_cast<float>(params.critical_roughness_m)) {}
  float slope_rad, step_m, roughness_m;
};

/// What was measured of a cell, as shares of the limits.
struct Measured {
  float slope, step, roughness;
};

/// Of what takes most off the score.
GroundKind WorstOf(const Measured& m) {
  const float slope = kSlopeWeight * m.slope, step = kStepWeight * m.step,
              roughness = kRoughnessWeight * m.roughness;
  if (step >= slope && step >= roughness) return GroundKind::kStep;
  return slope >= roughness ? GroundKind::kSlope : GroundKind::kRoughness;
}

/// Of a cell without support: whether rays were seen to go down there.
bool SeenBelow(const GroundImage& ground, size_t i) {
  return ground.kind[i] == CellKind::kBelow || ground.crossings[i] >= kDropCrossings;
}

/// Whether the nearest open cells were seen to be a drop, or were merely not seen.
GroundKind RimKind(const TerrainImage& image, const GroundImage& ground, int row, int col) {
  for (int r = std::max(0, row - 1); r <= std::min(image.side - 1, row + 1); ++r) {
    for (int c = std::max(0, col - 1); c <= std::min(image.side - 1, col + 1); ++c) {
      const size_t i = image.Index(r, c);
      if (image.open[i] && SeenBelow(ground, i)) return GroundKind::kDrop;
    }
  }
  return GroundKind::kUnknown;
}

/// Why nothing can stand on this cell, by itself; kFree where something can.
GroundKind KindOf(const TerrainImage& image, const GroundImage& ground, int row, int col, const Measured& m,
                  float ridge_m) {
  const size_t i = image.Index(row, col);
  if (ground.blocked[i]) return GroundKind::kObstacle;
  if (!image.solid[i]) return SeenBelow(ground, i) ? GroundKind::kDrop : GroundKind::kUnknown;
  if (image.distance2_open[i] <= kRim2) return RimKind(image, ground, row, col);
  if (!ground.headroom[i]) return GroundKind::kOverhang;
  if (m.step >= 1.0f || ridge_m > kRidge_m) return GroundKind::kStep;
  if (m.slope >= 1.0f) return GroundKind::kSlope;
  if (m.roughness >= 1.0f) return GroundKind::kRoughness;
  return GroundKind::kFree;
}

/// Ridges that stand alone. A cell before an edge that holds returns of the riser stands out from its row,
/// and where its neighbours along the edge hold none it is as narrow as a tube:
///
///            ____  wide enough for feet        _
///     . : : |                           not   | |  a tube
///     ______|                           _____ | |_____
///
/// But behind it a surface wide enough for feet goes on at its height, so that feet which lift over the edge
/// lift over it as well: what is no higher than such a surface within the riser's spread is the edge, whose
/// step is judged by itself, and no ridge.
///
/// What hides a gap from the sensor stands higher than what lies in it: `low_m` has the ground behind a tube
/// as low as beyond, where heights interpolated from the tube's top would make it wide.
std::vector<float> RidgesOffEdges(const TerrainImage& image, const std::vector<float>& low_m, int radius) {
  std::vector<float> ridge_m = Ridges(low_m, image.solid, image.side, image.side, radius);
  std::vector<float> wide_m(low_m);
  for (size_t i = 0; i < wide_m.size(); ++i) wide_m[i] -= ridge_m[i];
  wide_m = SlidingMax(wide_m, image.solid, image.side, image.side, kRiserSpread);
  for (size_t i = 0; i < ridge_m.size(); ++i) {
    if (image.solid[i]) ridge_m[i] = std::max(0.0f, low_m[i] - wide_m[i]);
  }
  return ridge_m;
}

/// Fills traversability and kind. Traversability is 1 on level, smooth ground, falls linearly with each of
/// slope, step and roughness, and is 0 where the kind is not kFree.
void Score(const TerrainParams& params, const GroundImage& ground, const std::vector<float>& step_m,
           const std::vector<float>& ridge_m, TerrainImage* image) {
  const Limits limits(params);
  image->traversability.assign(image->solid.size(), 0.0f);
  image->kind.assign(image->solid.size(), GroundKind::kUnknown);
  for (int r = 0; r < image->side; ++r) {
    for (int c = 0; c < image->side; ++c) {
      const size_t i = image->Index(r, c);
      const size_t block =
          static_cast<size_t>(r / 2) * static_cast<size_t>(image->planes.cols) + static_cast<size_t>(c / 2);
      const Measured m{image->planes.slope_rad[block] / limits.slope_rad, step_m[i] / limits.step_m,
                       image->planes.roughness_m[block] / limits.roughness_m};
      image->kind[i] = KindOf(*image, ground, r, c, m, ridge_m[i]);
      if (image->kind[i] != GroundKind::kFree) continue;
      const float score =
          1.0f - kSlopeWeight * m.slope - kStepWeight * m.step - kRoughnessWeight * m.roughness;
      image->traversability[i] = score;
      if (score <= 0.0f || score < static_cast<float>(params.min_traversability)) image->kind[i] = WorstOf(m);
    }
  }
}

/// What traversable ways join to the robot: by steps to the four neighbours, and from level to level.
class ReachFlood {
 public:
  explicit ReachFlood(const std::vector<TerrainImage>& levels)
      : levels_(levels), reached_(levels.size(), Mask(levels.front().solid.size(), 0)) {}

  /// From the robot's level, about the robot.
  std::vector<Mask> From(int row, int col, int seed_radius) {
    const int last = levels_.front().side - 1;
    for (int r = std::max(0, row - seed_radius); r <= std::min(last, row + seed_radius); ++r) {
      for (int c = std::max(0, col - seed_radius); c <= std::min(last, col + seed_radius); ++c)
        Reach(0, r, c);
    }
    for (size_t next = 0; next < queue_.size(); ++next) {
      const auto [level, i] = queue_[next];
      const int r = i / levels_.front().side, c = i % levels_.front().side;
      if (r > 0) Reach(level, r - 1, c);
      if (r < last) Reach(level, r + 1, c);
      if (c > 0) Reach(level, r, c - 1);
      if (c < last) Reach(level, r, c + 1);
      for (size_t other = 0; other < levels_.size(); ++other) {
        if (other != level && SameGround(level, other, static_cast<size_t>(i))) Reach(other, r, c);
      }
    }
    return std::move(reached_);
  }

 private:
  void Reach(size_t level, int r, int c) {
    const TerrainImage& image = levels_[level];
    const size_t i = image.Index(r, c);
    if (reached_[level][i] || image.kind[i] != GroundKind::kFree) return;
    reached_[level][i] = 1;
    queue_.emplace_back(level, static_cast<int>(i));
  }
  bool SameGround(size_t a, size_t b, size_t i) const {
    return std::abs(levels_[a].height_m[i] - levels_[b].height_m[i]) <= kSameGround_m;
  }

  const std::vector<TerrainImage>& levels_;
  std::vector<Mask> reached_;
  std::vector<std::pair<size_t, int>> queue_;
};

/// Zeroes what was not reached: the roof of a car is flat, but not ground.
void KeepReachable(const Mask& reached, TerrainImage* image) {
  for (size_t i = 0; i < reached.size(); ++i) {
    if (reached[i]) continue;
    image->traversability[i] = 0.0f;
    if (image->kind[i] == GroundKind::kFree) image->kind[i] = GroundKind::kCutOff;
  }
}

/// A foot may go where there is support, clear of rims and of the edges of steps by about 6 cm.
void MarkSteppable(const GroundImage& ground, const Mask& filled, const std::vector<float>& step_m,
                   TerrainImage* image) {
  const size_t count = image->solid.size();
  const std::vector<float> relief_m =
      SlidingRange(image->height_m, image->solid, image->side, image->side, 1);
  Mask riser(count);
  for (size_t i = 0; i < count; ++i) riser[i] = relief_m[i] > kRiser_m;
  const std::vector<int16_t> distance2_riser = SquaredDistance(riser, image->side, image->side, 1);
  image->steppable.assign(count, 0);
  for (size_t i = 0; i < count; ++i) {
    const bool uncertain = filled[i] && step_m[i] > kRiser_m;
    image->steppable[i] = image->solid[i] && !ground.blocked[i] && !uncertain && distance2_riser[i] > 1 &&
                          image->distance2_open[i] >= 4;
  }
}

/// All but what ways and distances decide.
TerrainImage AssessAlone(const TerrainParams& params, const GroundImage& ground, int distance_radius) {
  TerrainImage image;
  image.min_x = ground.min_x;
  image.min_y = ground.min_y;
  image.side = ground.side;
  image.distance_radius = distance_radius;
  Support support = FindSupport(params.cell_m, params.max_fill_m, ground);
  image.height_m = std::move(support.height_m);
  image.solid = std::move(support.solid);
  image.open = std::move(support.open);
  image.distance2_open = SquaredDistance(image.open, image.side, image.side, distance_radius);
  image.level_m = ground.reference_m;
  for (size_t i = 0; i < image.solid.size(); ++i) {
    if (image.solid[i]) image.level_m[i] = image.height_m[i];
  }

  const int plane_radius = std::max(1, static_cast<int>(std::lround(kPlaneRadius_m / (2.0 * params.cell_m))));
  image.planes = FitPlanes(image.height_m, image.solid, image.side, image.side, params.cell_m, plane_radius);
  const std::vector<float> step_m =
      SlidingRange(image.height_m, image.solid, image.side, image.side, kStepRadius);
  const int ridge_radius = std::max(1, static_cast<int>(std::lround(0.5 * kRidgeWidth_m / params.cell_m)));
  Score(params, ground, step_m, RidgesOffEdges(image, support.low_m, ridge_radius), &image);
  MarkSteppable(ground, support.filled, step_m, &image);
  return image;
}

}  // namespace

std::vector<TerrainImage> AssessLevels(const TerrainParams& params, const std::vector<GroundImage>& levels,
                                       int robot_row, int robot_col, int distance_radius) {
  std::vector<TerrainImage> images;
  for (const GroundImage& level : levels) images.push_back(AssessAlone(params, level, distance_radius));
  const std::vector<Mask> reached = ReachFlood(images).From(robot_row, robot_col, distance_radius);
  for (size_t level = 0; level < images.size(); ++level) {
    TerrainImage& image = images[level];
    KeepReachable(reached[level], &image);
    Mask blocks(image.solid.size());
    for (size_t i = 0; i < blocks.size(); ++i) blocks[i] = image.kind[i] != GroundKind::kFree;
    image.distance2_blocked = SquaredDistance(blocks, image.side, image.side, distance_radius);
  }
  return images;
}

TerrainImage AssessTerrain(const TerrainParams& params, const GroundImage& ground, int robot_row,
                           int robot_col, int distance_radius) {
  return std::move(AssessLevels(params, {ground}, robot_row, robot_col, distance_radius).front());
}

}  // namespace atlas::mapping::terrain
