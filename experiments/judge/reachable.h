// Where the robot can truly stand: a flood over the true ground from its spawn.
//
// The scene's triangles are cut to the columns of a grid, so each column knows the heights at which something
// is. A flood of the ground starts under the spawn and climbs from column to column by at most the robot's
// step; walls, edges, holes and low ceilings end it. The robot's centre may stand where its circle lies
// wholly on that ground, and gets there through passages that are wide enough to walk straight on.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

struct ReachOptions {
  double cell_m = 0.05;
  double slope_span_m = 0.40;  ///< the ground may rise by one step over this length, no more
};

/// Cells of a square grid, row-major; row along y.
struct ReachableSet {
  int rows = 0, cols = 0;
  double cell_m = 0.0;
  core::Vec2 origin = core::Vec2::Zero();  ///< lower corner of cell (0, 0)
  std::vector<float> ground_m;             ///< height of the ground; NaN where the flood never came
  std::vector<uint8_t> reachable;          ///< 1: the robot's centre can stand here, coming from the spawn

  size_t IndexOf(int row, int col) const { return static_cast<size_t>(row) * cols + col; }
  core::Vec2 CenterOf(int row, int col) const { return origin + cell_m * core::Vec2(col + 0.5, row + 0.5); }
  /// Cell under a point, or false outside.
  bool CellUnder(const core::Vec2& p, int* row, int* col) const;
  bool ReachableAt(const core::Vec2& p) const;
  double AreaM2() const;
};

/// Floods `region` (its xy extent). Nothing is reachable when the spawn has no ground under it.
ReachableSet FindReachable(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                           const core::Box3& region, const ReachOptions& options);

/// Reachable points of the lattice spawn + spacing * (i, j) (map axes), on the ground; row by row.
std::vector<core::Vec3> LatticePositions(const ReachableSet& set, const core::Vec3& spawn, double spacing_m);

}  // namespace atlas::experiments
