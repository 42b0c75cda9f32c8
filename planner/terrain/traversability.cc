#include "planner/terrain/traversability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/terrain/gap_filling.h"

namespace atlas::planner::terrain {
namespace {

constexpr double kPlaneRadius_m = 0.26;  ///< half side of the square that slope and roughness are fitted over
constexpr int kStepRadius = 2;           ///< cells
constexpr float kRiser_m = 0.06;         ///< neighbouring cells that differ by more are the edge of a step
constexpr double kRidgeWidth_m = 0.25;   ///< what is narrower is no place for feet ...
constexpr float kRidge_m = 0.06;  ///< ... and trips them where it stands out by more: a tube, a curb stone
constexpr float kSlopeWeight = 0.4f, kStepWeight = 0.3f, kRoughnessWeight = 0.3f;

/// 1 on level, smooth ground, falling linearly with each of slope, step and roughness; 0 beyond any limit and
/// on ridges.
std::vector<float> Score(const TerrainParams& params, const TerrainImage& image, const GroundImage& ground,
                         const std::vector<float>& step_m, const std::vector<float>& ridge_m) {
  const float max_slope_rad = static_cast<float>(core::Radians(params.critical_slope_deg));
  const float max_step_m = static_cast<float>(params.critical_step_m);
  const float max_roughness_m = static_cast<float>(params.critical_roughness_m);
  std::vector<float> score(image.solid.size(), 0.0f);
  for (int r = 0; r < image.side; ++r) {
    for (int c = 0; c < image.side; ++c) {
      const size_t i = image.Index(r, c);
      if (!image.solid[i] || ground.blocked[i] || !ground.headroom[i] || image.distance2_open[i] <= 2)
        continue;
      const size_t block =
          static_cast<size_t>(r / 2) * static_cast<size_t>(image.planes.cols) + static_cast<size_t>(c / 2);
      const float slope = image.planes.slope_rad[block] / max_slope_rad;
      const float step = step_m[i] / max_step_m;
      const float roughness = image.planes.roughness_m[block] / max_roughness_m;
      if (slope >= 1.0f || step >= 1.0f || roughness >= 1.0f || ridge_m[i] > kRidge_m) continue;
      score[i] = 1.0f - kSlopeWeight * slope - kStepWeight * step - kRoughnessWeight * roughness;
    }
  }
  return score;
}

/// Zeroes what no way over traversable cells joins to the robot: the roof of a car is flat, but not ground.
void KeepReachable(double min_traversability, int row, int col, int seed_radius, TerrainImage* image) {
  const auto passable = [&](size_t i) {
    return image->traversability[i] > 0.0f &&
           image->traversability[i] >= static_cast<float>(min_traversability);
  };
  Mask reached(image->solid.size(), 0);
  std::vector<int> queue;
  const auto reach = [&](int r, int c) {
    const size_t i = image->Index(r, c);
    if (reached[i] || !passable(i)) return;
    reached[i] = 1;
    queue.push_back(static_cast<int>(i));
  };
  const int last = image->side - 1;
  for (int r = std::max(0, row - seed_radius); r <= std::min(last, row + seed_radius); ++r) {
    for (int c = std::max(0, col - seed_radius); c <= std::min(last, col + seed_radius); ++c) reach(r, c);
  }
  for (size_t next = 0; next < queue.size(); ++next) {
    const int r = queue[next] / image->side, c = queue[next] % image->side;
    if (r > 0) reach(r - 1, c);
    if (r < last) reach(r + 1, c);
    if (c > 0) reach(r, c - 1);
    if (c < last) reach(r, c + 1);
  }
  for (size_t i = 0; i < reached.size(); ++i) {
    if (!reached[i]) image->traversability[i] = 0.0f;
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

}  // namespace

TerrainImage AssessTerrain(const TerrainParams& params, const GroundImage& ground, int robot_row,
                           int robot_col, int distance_radius) {
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

  const int plane_radius = std::max(1, static_cast<int>(std::lround(kPlaneRadius_m / (2.0 * params.cell_m))));
  image.planes = FitPlanes(image.height_m, image.solid, image.side, image.side, params.cell_m, plane_radius);
  const std::vector<float> step_m =
      SlidingRange(image.height_m, image.solid, image.side, image.side, kStepRadius);
  const int ridge_radius = std::max(1, static_cast<int>(std::lround(0.5 * kRidgeWidth_m / params.cell_m)));
  const std::vector<float> ridge_m =
      Ridges(image.height_m, image.solid, image.side, image.side, ridge_radius);
  image.traversability = Score(params, image, ground, step_m, ridge_m);
  KeepReachable(params.min_traversability, robot_row, robot_col, distance_radius, &image);
  MarkSteppable(ground, support.filled, step_m, &image);

  Mask blocks(image.solid.size());
  for (size_t i = 0; i < blocks.size(); ++i) {
    blocks[i] = image.traversability[i] <= 0.0f ||
                image.traversability[i] < static_cast<float>(params.min_traversability);
  }
  image.distance2_blocked = SquaredDistance(blocks, image.side, image.side, distance_radius);
  return image;
}

}  // namespace atlas::planner::terrain
