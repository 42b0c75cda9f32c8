#include "mapping/io/map_file.h"

namespace atlas::mapping {
namespace {

/// Whether a voxel belongs to the surface: occupied, or at most a voxel from the zero of the distance.
struct OnSurface {
  double resolution_m;
  bool operator()(OccupancyField::Value v) const { return OccupancyField::Occupied(v); }
  bool operator()(TsdfField::Value v) const {
    return TsdfField::Known(v) && std::abs(v.distance * TsdfField::UnitM(resolution_m)) <= resolution_m;
  }
};

}  // namespace

template <typename Field>
core::PointCloud SurfaceVoxels(const Octree<Field>& map) {
  const OnSurface on_surface{map.resolution_m()};
  core::PointCloud cloud;
  typename Octree<Field>::FineLeaf cells;
  for (const auto* chunk : map.Chunks()) {
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (chunk->Kind(block) == BlockKind::kUniform && !on_surface(chunk->uniform.Get(block))) continue;
      map.Expand(*chunk, block, &cells);
      const NodeKey offset = BlockOffset(block);
      const NodeKey corner{chunk->key.x * kChunkSide + offset.x * kBlockSide,
                           chunk->key.y * kChunkSide + offset.y * kBlockSide,
                           chunk->key.z * kChunkSide + offset.z * kBlockSide};
      for (int i = 0; i < kBlockVoxels; ++i) {
        if (!on_surface(cells.Get(i))) continue;
        const NodeKey voxel{corner.x + (i & 7), corner.y + (i >> 3 & 7), corner.z + (i >> 6)};
        cloud.points.push_back(map.CenterOf(voxel).template cast<float>());
      }
    }
  }
  return cloud;
}

template core::PointCloud SurfaceVoxels(const OccupancyOctree&);
template core::PointCloud SurfaceVoxels(const TsdfOctree&);

}  // namespace atlas::mapping
