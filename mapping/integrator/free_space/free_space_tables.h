// Stage 3, free space: how far each beam leaves room for cells, and the least of that over windows of beams.
//
//        column ->  own beam o, voxel centre *          range ->
//        +-----+-----+                                   sensor ---------[ own ]--[ veto ]----|--- surface
//        |  o  |  o  |  veto window of a voxel:          free if the centre lies before `own` of its cell
//        |    *|     |  the 2 x 2 cells about it,        and before `veto` of every cell of the window. own
//        +-----+-----+  2^k where voxels are             is nearer: a voxel that the beam pierces may hang
//        |  o  |  o  |  wider than cells                 below it by its support.
//        +-----+-----+
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/integrator/measurement/margins.h"

namespace atlas::mapping {

/// Minima of the margins: `surround` becomes the least over the 2 x 2 cells from (row, column); from row -1.
struct FreeSpaceTables : Margins {
  float pierce_voxels = 0.5f;  ///< a beam that passes this near to a cell's middle pierces it

  static constexpr int kLevels = 7;
  /// Scale 1: least over window_rows x window_columns from (row, column); from row -(window_rows - 1).
  std::array<std::vector<float>, kLevels> window;
  std::array<int, kLevels> window_rows, window_columns;

  /// Box tables: packed bounds over 2^k rows x 2^(k + box_shift) columns from (row, column) of the grid: low
  /// half the least `own`, high half 65535 - the greatest bound, both in units of box_unit_m.
  static constexpr int kBoxLevels = 6;
  std::vector<uint32_t> box;  ///< [level][row][box_pitch]
  size_t box_pitch = 0, box_stride = 0;
  int box_shift = 0;
  float box_unit_m = 0.001f;

  explicit FreeSpaceTables(const RangeImage& of);
};

/// From the margins that FindPlanes left.
void BuildTables(const ImageOptions& options, const SurfaceImage& surface, FreeSpaceTables* tables);

}  // namespace atlas::mapping
