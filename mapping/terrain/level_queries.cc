#include "mapping/terrain/level_queries.h"

#include <algorithm>
#include <cmath>

namespace atlas::mapping::terrain {
namespace {

static_assert(kMostLevels == TraversableGround::kMaxLevels);

}  // namespace

int LevelQueries::IndexAt(double x, double y) const {
  if (published_.levels.empty()) return -1;
  const TerrainImage& image = published_.levels.front();
  const int c = static_cast<int>(std::floor(x * inverse_cell_)) - image.min_x,
            r = static_cast<int>(std::floor(y * inverse_cell_)) - image.min_y;
  if (c < 0 || r < 0 || c >= image.side || r >= image.side) return -1;
  return r * image.side + c;
}

LevelQueries::Answering LevelQueries::At(const core::Vec3& p_odom) const {
  Answering answering;
  const int i = IndexAt(p_odom.x(), p_odom.y());
  if (i < 0) return answering;
  answering.cell = static_cast<size_t>(i);
  const TerrainImage* nearest = nullptr;
  float apart_m = static_cast<float>(TraversableGround::kSameLevel_m);
  const auto level_at = [&](const TerrainImage& image) { return image.level_m[answering.cell]; };
  for (const TerrainImage& image : published_.levels) {
    const float apart = std::abs(level_at(image) - static_cast<float>(p_odom.z()));
    if (!(nearest == nullptr ? apart <= apart_m : apart < apart_m)) continue;
    nearest = &image;
    apart_m = apart;
  }
  if (nearest == nullptr) return answering;
  answering.level[static_cast<size_t>(answering.count++)] = nearest;
  for (const TerrainImage& image : published_.levels) {
    if (&image == nearest || !(std::abs(level_at(image) - level_at(*nearest)) <= kSameGround_m)) continue;
    answering.level[static_cast<size_t>(answering.count++)] = &image;
  }
  return answering;
}

TraversableGround::Levels LevelQueries::LevelsAt(const core::Vec2& p_odom) const {
  TraversableGround::Levels levels;
  const int i = IndexAt(p_odom.x(), p_odom.y());
  if (i < 0) return levels;
  for (const TerrainImage& image : published_.levels) {
    const double height = static_cast<double>(image.level_m[static_cast<size_t>(i)]);
    const bool known = std::any_of(levels.begin(), levels.end(), [&](double other) {
      return std::abs(other - height) <= TraversableGround::kSameLevel_m;
    });
    if (std::isfinite(height) && !known) levels.Add(height);
  }
  return levels;
}

double LevelQueries::Traversability(const core::Vec3& p_odom) const {
  const Answering levels = At(p_odom);
  float most = 0.0f;
  for (const TerrainImage* level : levels) most = std::max(most, level->traversability[levels.cell]);
  return static_cast<double>(most);
}

GroundKind LevelQueries::KindAt(const core::Vec3& p_odom) const {
  const Answering levels = At(p_odom);
  if (levels.count == 0) return GroundKind::kUnknown;
  for (const TerrainImage* level : levels) {
    if (level->kind[levels.cell] == GroundKind::kFree) return GroundKind::kFree;
  }
  return levels.level.front()->kind[levels.cell];
}

double LevelQueries::Clearance(size_t cell, const std::vector<int16_t>& distance2) const {
  return params_.cell_m * std::sqrt(distance2[cell]);
}

/// No cell at distance 0 has its centre in the rectangle: halved until a distance decides.
bool LevelQueries::RectangleClear(const core::Vec2& centre, const Rectangle& shape,
                                  const std::vector<int16_t>& distance2) const {
  const int i = IndexAt(centre.x(), centre.y());
  if (i < 0 || distance2[static_cast<size_t>(i)] == 0) return false;
  const double reach = std::hypot(shape.half_length_m, shape.half_width_m);
  if (reach <= 0.5 * params_.cell_m) return true;
  if (Clearance(static_cast<size_t>(i), distance2) > reach + 0.71 * params_.cell_m) return true;
  Rectangle half = shape;
  core::Vec2 shift;
  if (shape.half_length_m >= shape.half_width_m) {
    shift = 0.5 * shape.half_length_m * shape.along;
    half.half_length_m *= 0.5;
  } else {
    shift = 0.5 * shape.half_width_m * core::Vec2(-shape.along.y(), shape.along.x());
    half.half_width_m *= 0.5;
  }
  return RectangleClear(centre - shift, half, distance2) && RectangleClear(centre + shift, half, distance2);
}

bool LevelQueries::FootprintFree(const core::Vec3& p_odom, double yaw_rad) const {
  const core::Vec2 along(std::cos(yaw_rad), std::sin(yaw_rad)), centre = p_odom.head<2>();
  const double rim = params_.edge_clearance_m;
  const Rectangle own{along, robot_.half_length_m, robot_.half_width_m};
  const Rectangle grown{along, robot_.half_length_m + rim, robot_.half_width_m + rim};
  const Answering levels = At(p_odom);
  return std::any_of(levels.begin(), levels.end(), [&](const TerrainImage* level) {
    return RectangleClear(centre, own, level->distance2_blocked) &&
           RectangleClear(centre, grown, level->distance2_open);
  });
}

bool LevelQueries::CircleFree(const core::Vec3& p_odom) const {
  const double radius = robot_.footprint_radius_m;
  const Answering levels = At(p_odom);
  return std::any_of(levels.begin(), levels.end(), [&](const TerrainImage* level) {
    return Clearance(levels.cell, level->distance2_blocked) >= radius &&
           Clearance(levels.cell, level->distance2_open) >= radius + params_.edge_clearance_m;
  });
}

TraversableGround::Surface LevelQueries::SurfaceAt(const core::Vec3& p_odom) const {
  TraversableGround::Surface surface;
  surface.height_m = static_cast<double>(published_.ground_m);
  const Answering levels = At(p_odom);
  if (levels.count == 0) return surface;
  const TerrainImage* level = levels.level.front();
  for (const TerrainImage* other : levels) {
    if (level->kind[levels.cell] != GroundKind::kFree) level = other;
  }
  const PlaneFits& planes = level->planes;
  const size_t side = static_cast<size_t>(level->side), row = levels.cell / side, col = levels.cell % side;
  const size_t block = row / 2 * static_cast<size_t>(planes.cols) + col / 2;
  if (!std::isfinite(planes.height_m[block])) return surface;
  surface.height_m = static_cast<double>(planes.height_m[block]);
  surface.slope_rad = static_cast<double>(planes.slope_rad[block]);
  surface.roughness_m = static_cast<double>(planes.roughness_m[block]);
  return surface;
}

}  // namespace atlas::mapping::terrain
