// Which of a cell's layers is the ground: a wave that starts under the robot and goes outward, over linked
// ground first, carrying the height at which ground is expected. So a floor below a grating, a table or an
// arch is told from the surface that the robot stands on.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/terrain/layered_grid.h"

namespace atlas::mapping::terrain {

enum class CellKind : uint8_t {
  kUnseen,    ///< nothing near the expected height
  kGround,    ///< a surface linked to the one that the robot stands on
  kObstacle,  ///< something at the body's height, no ground below it seen
  kBelow,     ///< only returns from far below
};

struct WaveParams {
  float link_m = 0.25f;      ///< ground of neighbouring cells differs by no more
  float step_m = 0.12f;      ///< things higher than this above the ground are in the way
  float headroom_m = 0.84f;  ///< up to here
};

/// A square of cells, row-major, row = y; cell (r, c) is grid cell (min_x + c, min_y + r).
struct GroundImage {
  int min_x = 0, min_y = 0, side = 0;
  std::vector<CellKind> kind;
  std::vector<float> height_m;      ///< of the ground; of the obstacle's top; of the floor below; else NaN
  std::vector<float> reference_m;   ///< where ground is expected
  std::vector<uint16_t> support;    ///< returns on the ground; 0 where assumed
  std::vector<uint16_t> crossings;  ///< rays that crossed the expected height and went on down
  std::vector<uint8_t> blocked;     ///< something in the way at the body's height

  std::vector<uint8_t> headroom;  ///< the body's space was seen to be empty; filled by the caller

  size_t Index(int row, int col) const {
    return static_cast<size_t>(row) * static_cast<size_t>(side) + static_cast<size_t>(col);
  }
};

/// Fills `image` (its min_x, min_y and side say where) from `grid`, and hands the expected heights back to
/// the grid. The wave starts from the cells within `seed_radius_m` of `robot`, where ground is at `ground_m`.
/// @pre the image lies within the grid.
void FindGround(const WaveParams& params, const core::Vec2& robot, double seed_radius_m, float ground_m,
                LayeredGrid* grid, GroundImage* image);

}  // namespace atlas::mapping::terrain
