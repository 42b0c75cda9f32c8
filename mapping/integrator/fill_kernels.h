// Free space decided projectively: which boxes and cells lie in front of what the beams met.
#pragma once

#include <array>
#include <cstdint>

#include "mapping/integrator/scan_image.h"
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

/// 16 cubes by their centres in window coordinates. A bit each: `full`, wholly in front of every beam that
/// can touch it; `mixed`, may hold free cells (or, with ImageOptions::reach_behind_m, cells near a return).
void TestBoxes(const ScanImage& image, const ScanFrame& frame, const float* x, const float* y, const float* z,
               float half_side_voxels, uint32_t* mixed, uint32_t* full);

/// The same for all blocks of the chunk whose corner has these window coordinates.
void TestBlocks(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, BlockMask* mixed,
                BlockMask* full);

/// A bit a voxel of a block, by z-layers.
struct VoxelBits {
  std::array<uint64_t, kBlockSide> layer;
};
/// A cell is free if its nearest beam returned behind it and no beam around it returned in front of it. Where
/// beams around it did, a voxel is still free if its own beam pierces it, unless beams are voxels apart
/// there.
/// @{
/// Adds the free voxels of these octants (4^3 voxels each, x fastest) of the block with this corner.
void TestVoxels(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, uint32_t octants,
                VoxelBits* free);
/// Cells of 2^3 (64 bits) or 4^3 voxels (8 bits) of a block, x fastest. @pre scale is 2 or 4.
uint64_t TestCells(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, int scale);
/// @}

/// Signed distances of a block's voxels to the planes of their nearest beams, in `unit_m` clamped to
/// +-truncation_m; kNoDistance where the nearest beam hit nothing or the plane is farther behind. Returns
/// whether any lies within the truncation.
bool MeasureDistances(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner,
                      float truncation_m, float unit_m, int16_t* out);
/// The same of its 64 cells of 2^3 voxels.
bool MeasureCellDistances(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner,
                          float truncation_m, float unit_m, int16_t* out);

}  // namespace atlas::mapping
