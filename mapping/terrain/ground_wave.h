// Which of a cell's layers is the ground: a wave that starts under the robot and goes outward, over linked
// ground first, carrying the height at which ground is expected. So a floor below a grating, a table or an
// arch is told from the surface that the robot stands on.
//
// The wave visits every cell once. Where linked ground leads it over ground that it visited already, floors
// lie above one another; those that it could not take are levels of their own, each by a wave of its own:
//
//        c_____________   at `s` the first wave comes up the ramp to cells that it holds at height `r`
//        already:
//       /s                seeds of another level. The second wave starts there, takes the whole upper floor
//      /                  `c`, and the ramp and the lower floor `b` besides, as far as no upper floor is
//      above.
//   b_/__r____________
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

constexpr int kMostLevels = 4;

/// Where the first wave starts: from the cells within `seed_radius_m` of the robot, where ground is at
/// `ground_m`.
struct WaveStart {
  core::Vec2 robot = core::Vec2::Zero();
  double seed_radius_m = 0.0;
  float ground_m = 0.0f;
};

/// Ground by level, at most kMostLevels; the one that the robot stands on first. `where` gives the square
/// (min_x, min_y, side). Expected heights of the first level are handed back to the grid, which counts
/// crossings by them: rays that went through another level's ground are not counted, its images have 0, and a
/// hole in it is known by the floor that was seen below it.
/// @pre the square lies within the grid.
std::vector<GroundImage> FindLevels(const WaveParams& params, const WaveStart& start,
                                    const GroundImage& where, LayeredGrid* grid);

}  // namespace atlas::mapping::terrain
