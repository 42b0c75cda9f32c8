// The layout that all images of a scan share: the beam grid, and the columns of it that the scan fills.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry.h"
#include "mapping/integrator/projection/beam_grid.h"

namespace atlas::mapping {

/// What the images need to know of the integrator's parameters.
struct ImageOptions {
  float resolution_m = 0.05f;
  float max_range_m = 60.0f;
  float void_range_m = 20.0f;  ///< 0: void rays are no evidence
  float sigma_min_m = 0.015f;
  float lambda_sigma = 0.0005f;
  float remap_stop_rad = 0.001f;
  float reach_behind_m = 0.0f;  ///< voxels this far behind a return still matter to the fill stage
  int max_scale = 4;
  bool motion_aware = true;
  int threads = 1;
};

struct GridColumns {
  static constexpr int kWindowReach = 64;  ///< columns: no window of the free-space tables reaches farther
  const BeamGrid* grid = nullptr;
  int rows = 0, columns = 0;
  /// The columns that the stages fill, [first, last) in whole groups of 16: all, or those that see what is
  /// kept (KeepColumns). What the others hold is left over from other scans.
  struct Run {
    size_t first, last;
  };
  std::vector<Run> runs;

  explicit GridColumns(const BeamGrid& beams)
      : grid(&beams),
        rows(beams.rows),
        columns(beams.columns),
        runs(1, {0, static_cast<size_t>(beams.columns)}) {}
  size_t cells() const { return static_cast<size_t>(rows) * static_cast<size_t>(columns); }
  bool Filled(size_t column) const {
    for (const Run& run : runs) {
      if (column >= run.first && column < run.last) return true;
    }
    return false;
  }
};

/// Narrows the columns that are filled to those in which parts of the box may lie, and as many beside them as
/// windows reach; nullopt: all.
void KeepColumns(const std::optional<core::Box3>& box_map, const core::Pose& T_map_lidar, GridColumns* image);

}  // namespace atlas::mapping
