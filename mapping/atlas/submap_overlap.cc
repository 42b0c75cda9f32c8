#include "mapping/atlas/submap_overlap.h"

#include "mapping/octree/queries.h"

namespace atlas::mapping {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using Field = OccupancyField;

/// Looks voxels up one after another, remembering the chunk of the last one.
class NearbyVoxels {
 public:
  explicit NearbyVoxels(const OccupancyOctree& tree) : tree_(tree) {}
  int8_t At(const NodeKey& voxel) {
    const NodeKey key = voxel.Up(kChunkLevel);
    if (!looked_up_ || !(key == key_)) {
      chunk_ = tree_.Find(key);
      key_ = key;
      looked_up_ = true;
    }
    if (chunk_ == nullptr) return Field::Unknown();
    const int block = BlockIndexOf(voxel), index = VoxelIndex(voxel.x, voxel.y, voxel.z);
    switch (chunk_->Kind(block)) {
      case BlockKind::kUniform:
        return chunk_->uniform.Get(block);
      case BlockKind::kCoarse:
        return tree_.Coarse(*chunk_, block).Get(CellOfVoxel(index));
      case BlockKind::kFine:
        break;
    }
    return tree_.Fine(*chunk_, block).Get(index);
  }

 private:
  const OccupancyOctree& tree_;
  const OccupancyOctree::Chunk* chunk_ = nullptr;
  NodeKey key_;
  bool looked_up_ = false;
};

}  // namespace

uint64_t KnownVoxels(const OccupancyOctree& tree) {
  uint64_t known = 0;
  ForEachCell(tree, [&](const NodeKey&, int level, int8_t) { known += uint64_t{1} << 3 * level; });
  return known;
}

SubmapOverlap OverlapOf(const OccupancyOctree& read, uint64_t known_read, const OccupancyOctree& ref,
                        uint64_t known_ref, const Pose& T_ref_read) {
  if (known_read == 0 || known_ref == 0) return {};
  NearbyVoxels nearby(ref);
  const double resolution_m = read.resolution_m(), inverse = 1.0 / ref.resolution_m();
  const auto same_at = [&](const Vec3& p_read, int8_t value) {
    const int8_t other = nearby.At(VoxelKeyAt(T_ref_read * p_read, inverse));
    return Field::Known(other) && Field::Occupied(other) == Field::Occupied(value);
  };
  uint64_t same = 0;
  ForEachCell(read, [&](const NodeKey& key, int level, int8_t value) {
    const int split = level == kBlockLevel ? 2 : 1;  // a side
    const int side = (1 << level) / split;           // voxels
    for (int i = 0; i < split * split * split; ++i) {
      const Vec3 at(split * key.x + (i & 1), split * key.y + (i >> 1 & 1), split * key.z + (i >> 2));
      if (same_at(resolution_m * side * (at.array() + 0.5), value))
        same += static_cast<uint64_t>(side) * static_cast<uint64_t>(side * side);
    }
  });
  const auto n = static_cast<double>(same);
  return {n / static_cast<double>(known_read), n / static_cast<double>(known_ref)};
}

SubmapOverlap OverlapOf(const Box3& read, const Box3& ref) {
  const Box3 both{read.min.cwiseMax(ref.min), read.max.cwiseMin(ref.max)};
  if (read.Empty() || ref.Empty() || both.Empty()) return {};
  const double volume = both.Size().prod();
  return {volume / read.Size().prod(), volume / ref.Size().prod()};
}

}  // namespace atlas::mapping
