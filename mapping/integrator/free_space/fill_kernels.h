// Free space decided projectively: which boxes and cells lie in front of what the beams met.
#pragma once

#include <array>
#include <cstdint>

#include "mapping/integrator/free_space/free_space_tables.h"
#include "mapping/integrator/free_space/voxel_bits.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// How the voxel lattice lies in the LiDAR frame of a scan. Window coordinates count voxels from the corner
/// of chunk `first_chunk`.
struct ScanFrame {
  NodeKey first_chunk;
  std::array<int, 3> chunks = {};  ///< of the window, along x, y, z
  float resolution_m = 0.05f;
  float sensor[3] = {};   ///< window coordinates
  float axis[3][3] = {};  ///< [map axis]: one voxel along it, metres in the LiDAR frame
  /// Offsets of a group's 16 cells from its first, [component][cell]. Scale 1: 8 x 2 x 1 and, of a half
  /// block, 4 x 4 x 1 cells; scale 2: 4 x 4 x 1; scale 4: 2 x 2 x 2, twice.
  struct Lanes {
    alignas(64) float offset[3][16];
  };
  Lanes lanes_1, lanes_1_octant, lanes_2, lanes_4;
  /// @pre axis is set.
  void SetLanes();

  /// Metres in the LiDAR frame of a point in window coordinates.
  void ToLidar(float x, float y, float z, float out[3]) const {
    const float dx = x - sensor[0], dy = y - sensor[1], dz = z - sensor[2];
    for (int c = 0; c < 3; ++c) out[c] = dx * axis[0][c] + dy * axis[1][c] + dz * axis[2][c];
  }
};

/// What 16 cubes are to a scan, a bit each.
struct CubeTests {
  uint32_t full = 0;   ///< wholly in front of every beam that can touch it
  uint32_t mixed = 0;  ///< may hold free cells (or, with ImageOptions::reach_behind_m, cells near a return)
  uint32_t two_apart = 0, four_apart = 0;  ///< beams are at least so many voxels apart there (4.5.1)
  uint32_t smooth = 0;                     ///< its CubeSlopes hold, where they were asked for
};
/// @param x, y, z  centres in window coordinates.
CubeTests TestBoxes(const FreeSpaceTables& tables, const ScanFrame& frame, const float* x, const float* y,
                    const float* z, float half_side_voxels);

/// Grid coordinates within 16 cubes by first order: at their middles, and what a voxel along each map axis
/// adds. Second order adds less than 0.1 voxel, uneven beams less than 0.05 row, where the slopes are said to
/// hold.
struct CubeSlopes {
  alignas(64) float u[16], v[16], distance[16], du[3][16], dv[3][16], ddistance[3][16];
  alignas(64) float metres_per_column[16], metres_per_row[16];
  /// Windows of the grid, of kRows[i] x kColumns[i] cells. All cells within the grid's rows that are asked
  /// for lie in window[lane] from here; kWindows: in none.
  static constexpr int kWindows = 2, kRows[] = {4, 8}, kColumns[] = {8, 16};
  alignas(64) int32_t first_column[16], first_row[16], window[16];
};
/// The octants (4^3 voxels each, x fastest) of two blocks.
struct OctantTests {
  CubeTests cubes;
  CubeSlopes slopes;
};
void TestOctants(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey corner[2],
                 OctantTests* out);

/// What the blocks of a chunk are to a scan, as CubeTests.
struct BlockTests {
  BlockMask mixed, full, two_apart, four_apart;
};
/// @param corner  of the chunk, window coordinates.
void TestBlocks(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                BlockTests* out);

/// First order within up to 16 blocks, for their cells of 2^3 voxels. Returns the lanes where it holds.
uint32_t FindBlockSlopes(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey* corners,
                         size_t count, CubeSlopes* out);

/// A cell is free if its nearest beam returned behind it and no beam around it returned in front of it. Where
/// beams around it did, a voxel is still free if its own beam pierces it, unless beams are voxels apart
/// there.
/// @{
/// Adds the free voxels of these octants of the block with this corner, whose tests are `tests` from lane
/// `first` on.
void TestVoxels(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                const OctantTests& tests, int first, uint32_t octants, VoxelBits* free);
/// The 64 cells of 2^3 voxels of a block, x fastest. @param slopes  from lane `lane` on, if not null.
uint64_t TestCells(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey& corner,
                   const CubeSlopes* slopes, size_t lane);
/// The 8 cells of 4^3 voxels of two blocks, 8 bits each.
uint32_t TestWideCells(const FreeSpaceTables& tables, const ScanFrame& frame, const NodeKey corner[2]);
/// @}

/// Signed distances of a block's voxels to the planes of their nearest beams, in `unit_m` clamped to
/// +-truncation_m; kNoDistance where the nearest beam hit nothing or the plane is farther behind. Returns
/// whether any lies within the truncation.
bool MeasureDistances(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                      float truncation_m, float unit_m, int16_t* out);
/// The same of its 64 cells of 2^3 voxels.
bool MeasureCellDistances(const SurfaceImage& surface, const ScanFrame& frame, const NodeKey& corner,
                          float truncation_m, float unit_m, int16_t* out);

}  // namespace atlas::mapping
