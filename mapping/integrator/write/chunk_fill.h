// Applies a scan to one chunk of the octree.
#pragma once

#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/surface/hit_scatter.h"
#include "mapping/integrator/write/block_writer.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// What every chunk of a scan shares. Read-only while chunks are filled, by any number of threads.
struct FillContext {
  const FreeSpaceTables* tables = nullptr;
  const SurfaceImage* surface = nullptr;
  const ScanFrame* frame = nullptr;
  const HitScatter* hits = nullptr;
  NodeKey keep_min, keep_max;  ///< window coordinates of the kept voxels, [min, max)
  WriteRules rules;
  int max_scale = 4;
  float truncation_m = 0.0f;  ///< TSDF: at scale 1
  float distance_unit_m = 1.0f;
};

/// A chunk of the window and what its blocks are to the scan.
struct ChunkWork {
  NodeKey window;         ///< chunk coordinates in the window
  size_t index = 0;       ///< in the window
  bool all_full = false;  ///< no block needs a test of its own
  bool tested = false;    ///< its blocks are tested
  bool cut = false;       ///< part of it lies outside what is kept
  BlockTests blocks;
};

template <typename Field>
void FillChunk(const FillContext& context, const ChunkWork& work, int worker, Octree<Field>* map,
               typename Octree<Field>::Chunk* chunk);

}  // namespace atlas::mapping
