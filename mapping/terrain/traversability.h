// From ground per cell to where a robot may stand: gaps filled, holes kept, slope, step and roughness (thesis
// 3.5), distances to what blocks.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/terrain/elevation_map.h"
#include "mapping/terrain/grid_filters.h"
#include "mapping/terrain/ground_wave.h"

namespace atlas::mapping::terrain {

/// What queries read. Row-major, row = y; cell (r, c) is grid cell (min_x + c, min_y + r).
struct TerrainImage {
  int min_x = 0, min_y = 0, side = 0;
  std::vector<float> level_m;   ///< where this level's ground is, or is expected
  std::vector<float> height_m;  ///< of the supporting surface; of what is seen elsewhere; NaN where neither
  Mask solid;                   ///< supporting surface, measured or filled
  Mask steppable;
  Mask open;  ///< hole, drop, or unknown: nothing to stand on
  std::vector<float> traversability;
  std::vector<GroundKind> kind;  ///< why
  PlaneFits planes;
  int distance_radius = 0;                 ///< cells; distances saturate beyond
  std::vector<int16_t> distance2_blocked;  ///< squared, in cells, to the nearest cell that blocks
  std::vector<int16_t> distance2_open;     ///< squared, in cells, to the nearest open cell

  size_t Index(int row, int col) const {
    return static_cast<size_t>(row) * static_cast<size_t>(side) + static_cast<size_t>(col);
  }
};

/// @param robot_row,robot_col  where the robot stands: cells that no traversable way joins to it block.
TerrainImage AssessTerrain(const TerrainParams& params, const GroundImage& ground, int robot_row,
                           int robot_col, int distance_radius);

/// Of levels over the same square, the robot's first. A way leads from one to another where both hold the
/// same ground. @pre there is one.
std::vector<TerrainImage> AssessLevels(const TerrainParams& params, const std::vector<GroundImage>& levels,
                                       int robot_row, int robot_col, int distance_radius);

/// Ground of two levels is the same where its heights differ by less: they come from the same returns, and
/// were smoothed among different neighbours.
constexpr float kSameGround_m = 0.06f;

}  // namespace atlas::mapping::terrain
