// The surface in the cells of one chunk: those between the centres of a voxel of the chunk and its seven
// upper neighbours, which may lie in the next chunks.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "mapping/meshing/block_samples.h"
#include "mapping/meshing/cube_table.h"

namespace atlas::mapping {

struct ChunkSurface {
  core::TriMesh mesh;  ///< in the map's frame
  /// A vertex that other chunks may share, and the edge it lies on: twin vertices have equal keys.
  struct Shared {
    NodeKey voxel;  ///< the end with the lower coordinates
    int axis;
    uint32_t vertex;
  };
  std::vector<Shared> shared;
};

/// Working memory of one thread, used for any number of chunks one after another.
template <typename Field>
class ChunkMesher {
 public:
  ChunkMesher(const Octree<Field>& map, bool undo_shift);
  /// @pre summaries are current (Octree::Propagate).
  ChunkSurface Extract(const typename Octree<Field>::Chunk& chunk);

 private:
  void MarkSolidBlocks();
  bool MayCross(int block) const;
  void ExtractBlock(int block, ChunkSurface* surface);
  void ExtractCell(const NodeKey& cell, unsigned inside, ChunkSurface* surface);
  uint32_t VertexOn(const NodeKey& voxel, int axis, ChunkSurface* surface);

  const Octree<Field>& map_;
  bool undo_shift_;
  CubeTable table_;
  ChunkNeighbours<Field> around_;
  NodeKey chunk_, block_;                      ///< in their own units; the block's in its chunk
  std::array<bool, size_t{9} * 9 * 9> solid_;  ///< blocks of the chunk and the next ones that may hold inside
  BlockSamples<Field> samples_;
  std::vector<uint32_t> vertex_on_edge_;  ///< of each edge of the chunk and its upper border
  std::vector<size_t> edges_set_;
};

extern template class ChunkMesher<OccupancyField>;
extern template class ChunkMesher<TsdfField>;

}  // namespace atlas::mapping
