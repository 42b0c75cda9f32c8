#include "mapping/atlas/submap_overlap.h"

#include "mapping/atlas/block_window.h"
#include "mapping/atlas/submap_outline.h"
#include "mapping/octree/queries.h"

namespace atlas::mapping {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using Field = OccupancyField;

/// Voxels of `read` whose centres lie in voxels of `ref` that are known to be the same.
class SameVoxels {
 public:
  SameVoxels(const OccupancyOctree& read, const OccupancyOctree& ref, const Pose& T_ref_read)
      : read_(read),
        T_ref_read_(T_ref_read),
        inverse_(1.0 / ref.resolution_m()),
        half_block_(HalfSizeOfTurned(kBlockSide * read.resolution_m(), T_ref_read)),
        chunks_(ref),
        window_(ref) {}

  uint64_t InChunk(const OccupancyOctree::Chunk& chunk) {
    uint64_t same = 0;
    for (int block = 0; block < kChunkBlocks; ++block) {
      const NodeKey offset = BlockOffset(block);
      const NodeKey at{8 * chunk.key.x + offset.x, 8 * chunk.key.y + offset.y, 8 * chunk.key.z + offset.z};
      switch (chunk.Kind(block)) {
        case BlockKind::kUniform:
          same += InUniform(at, chunk.uniform.Get(block));
          break;
        case BlockKind::kCoarse:
          same += InLeaf<4>(at, read_.Coarse(chunk, block).log_odds);
          break;
        case BlockKind::kFine:
          same += InLeaf<8>(at, read_.Fine(chunk, block).log_odds);
          break;
      }
    }
    return same;
  }

 private:
  static bool Same(int8_t a, int8_t b) { return a > 0 ? b > 0 : a < 0 && b < 0; }

  uint64_t InUniform(const NodeKey& block, int8_t value) {
    if (!Field::Known(value)) return 0;
    uint64_t same = 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 octant(2 * block.x + (i & 1), 2 * block.y + (i >> 1 & 1), 2 * block.z + (i >> 2));
      const Vec3 p_ref = T_ref_read_ * (4.0 * read_.resolution_m() * (octant.array() + 0.5)).matrix();
      if (Same(chunks_.At(VoxelKeyAt(p_ref, inverse_)), value)) same += 64;
    }
    return same;
  }

  /// Of a leaf of `kSide` cells a side.
  template <int kSide>
  uint64_t InLeaf(const NodeKey& block, const int8_t* cells) {
    constexpr int kCells = kSide * kSide * kSide;
    constexpr uint64_t kVoxels = kBlockVoxels / kCells;  // a cell
    const double block_m = kBlockSide * read_.resolution_m();
    const Vec3 center = T_ref_read_ * (block_m * (Vec3(block.x, block.y, block.z).array() + 0.5)).matrix();
    window_.MoveTo(VoxelKeyAt(center - half_block_, inverse_).Up(kBlockLevel),
                   VoxelKeyAt(center + half_block_, inverse_).Up(kBlockLevel));
    uint64_t same = 0;
    if (window_.one_value()) {
      for (int i = 0; i < kCells; ++i) same += Same(cells[i], window_.value());
      return kVoxels * same;
    }
    // The columns of the rotation times the coordinates of cells.
    Vec3 by_x[kSide], by_y[kSide], by_z[kSide];
    const double cell_m = block_m / kSide;
    for (int i = 0; i < kSide; ++i) {
      by_x[i] = T_ref_read_.linear().col(0) * (cell_m * (kSide * block.x + i + 0.5));
      by_y[i] = T_ref_read_.linear().col(1) * (cell_m * (kSide * block.y + i + 0.5));
      by_z[i] = T_ref_read_.linear().col(2) * (cell_m * (kSide * block.z + i + 0.5));
    }
    for (int row = 0; row < kSide * kSide; ++row) {
      const Vec3 &of_y = by_y[row % kSide], &of_z = by_z[row / kSide];
      for (int x = 0; x < kSide; ++x) {
        const int8_t value = cells[row * kSide + x];
        if (Field::Known(value))
          same += Same(window_.At(VoxelKeyAt(by_x[x] + of_y + of_z + T_ref_read_.translation(), inverse_)),
                       value);
      }
    }
    return kVoxels * same;
  }

  const OccupancyOctree& read_;
  const Pose T_ref_read_;
  const double inverse_;
  const Vec3 half_block_;
  NearbyChunks chunks_;
  BlockWindow window_;
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
  SameVoxels voxels(read, ref, T_ref_read);
  uint64_t same = 0;
  for (const OccupancyOctree::Chunk* chunk : read.Chunks()) same += voxels.InChunk(*chunk);
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
