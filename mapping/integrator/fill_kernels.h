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

/// Free cells of a block. Scale 1: a bit a voxel in `voxels`; 2: a bit a cell of 2^3 in voxels[0]; 4: the
/// low 8 bits of voxels[0].
struct FreeCells {
  std::array<uint64_t, kBlockSide> voxels;
};
/// A cell is free if its nearest beam returned behind it and no beam around it returned in front of it, or
/// its own beam pierces it. Returns whether some cell is free only since it is pierced.
bool TestCells(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner, int scale,
               FreeCells* out);

/// Signed distances of a block's voxels to the planes of their nearest beams, in `unit_m` clamped to
/// +-truncation_m; kNoDistance where the nearest beam hit nothing or the plane is farther behind. Returns
/// whether any lies within the truncation.
bool MeasureDistances(const ScanImage& image, const ScanFrame& frame, const NodeKey& corner,
                      float truncation_m, float unit_m, int16_t* out);

}  // namespace atlas::mapping
