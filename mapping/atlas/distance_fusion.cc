#include "mapping/atlas/distance_fusion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using Field = TsdfField;
using Chunk = TsdfOctree::Chunk;

/// A tree read voxel by voxel, neighbours after one another.
class Reader {
 public:
  explicit Reader(const TsdfOctree& tree) : tree_(tree) {}

  Field::Value At(const NodeKey& voxel) {
    const NodeKey block = voxel.Up(kBlockLevel);
    if (!moved_ || !(block == block_)) MoveTo(block);
    switch (kind_) {
      case BlockKind::kFine:
        return fine_->Get(VoxelIndex(voxel.x, voxel.y, voxel.z));
      case BlockKind::kCoarse:
        return coarse_->Get(CellOfVoxel(VoxelIndex(voxel.x, voxel.y, voxel.z)));
      default:
        return uniform_;
    }
  }
  BlockKind KindAt(const NodeKey& block) {
    if (!moved_ || !(block == block_)) MoveTo(block);
    return kind_;
  }

 private:
  void MoveTo(const NodeKey& block) {
    moved_ = true;
    block_ = block;
    const Chunk* const chunk = tree_.Find(block.Up(kChunkLevel - kBlockLevel));
    const int index = BlockIndex(block.x, block.y, block.z);
    kind_ = chunk != nullptr ? chunk->Kind(index) : BlockKind::kUniform;
    if (kind_ == BlockKind::kFine) {
      fine_ = &tree_.Fine(*chunk, index);
    } else if (kind_ == BlockKind::kCoarse) {
      coarse_ = &tree_.Coarse(*chunk, index);
    } else {
      uniform_ = chunk != nullptr ? chunk->uniform.Get(index) : Field::Unknown();
    }
  }

  const TsdfOctree& tree_;
  bool moved_ = false;
  NodeKey block_;
  BlockKind kind_ = BlockKind::kUniform;
  const TsdfOctree::FineLeaf* fine_ = nullptr;
  const TsdfOctree::CoarseLeaf* coarse_ = nullptr;
  Field::Value uniform_;
};

/// A submap's distances at the places of another's voxels.
class Resampled {
 public:
  Resampled(const TsdfOctree& from, const Pose& T_from_to)
      : T_from_to_(T_from_to), inverse_(1.0 / from.resolution_m()), reader_(from) {}

  Field::Value At(const Vec3& p_to) {
    const Vec3 p = inverse_ * (T_from_to_ * p_to);  // in voxels
    const Field::Value held = reader_.At({FloorToInt(p.x()), FloorToInt(p.y()), FloorToInt(p.z())});
    if (!Field::Known(held)) return held;
    const NodeKey low{FloorToInt(p.x() - 0.5), FloorToInt(p.y() - 0.5), FloorToInt(p.z() - 0.5)};
    const Vec3 share = p - Vec3(low.x + 0.5, low.y + 0.5, low.z + 0.5);
    double distance = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const Field::Value at = reader_.At({low.x + x, low.y + y, low.z + z});
      if (!Field::Known(at)) return held;
      distance += (x ? share.x() : 1.0 - share.x()) * (y ? share.y() : 1.0 - share.y()) *
                  (z ? share.z() : 1.0 - share.z()) * at.distance;
    }
    return {static_cast<int16_t>(std::lround(distance)), held.weight};
  }

  /// What all of a cube of `to` would read: its one value, or nothing where there may be several. The finest
  /// kind of block that it meets.
  struct Around {
    std::optional<Field::Value> all;
    BlockKind finest = BlockKind::kUniform;
  };
  Around About(const Vec3& center_to, double side_m) {
    const Vec3 center = T_from_to_ * center_to;
    // One voxel more for the corners between which is read.
    const Vec3 half =
        (T_from_to_.linear().cwiseAbs() * Vec3::Constant(0.5 * side_m)).array() + 0.5 / inverse_;
    const NodeKey low = VoxelKeyAt(center - half, inverse_).Up(kBlockLevel),
                  high = VoxelKeyAt(center + half, inverse_).Up(kBlockLevel);
    Around around;
    bool first = true, same = true;
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          around.finest = std::max(around.finest, reader_.KindAt({x, y, z}));
          const Field::Value value = reader_.At({8 * x, 8 * y, 8 * z});
          if (first) around.all = value;
          same = same && value == *around.all;
          first = false;
        }
      }
    }
    if (!same || around.finest != BlockKind::kUniform) around.all.reset();
    return around;
  }

 private:
  const Pose T_from_to_;
  const double inverse_;
  Reader reader_;
};

template <int N, typename Leaf, typename Sample>
void FuseCells(Leaf* leaf, const Sample& sample) {
  for (int i = 0; i < N; ++i) leaf->Set(i, FusedDistance(leaf->Get(i), sample(i)));
}

void FuseBlock(Resampled* from, TsdfOctree* to, Chunk* chunk, int block) {
  const NodeKey offset = BlockOffset(block);
  const double voxel_m = to->resolution_m();
  const Vec3 low = voxel_m * Vec3(8 * (8 * chunk->key.x + offset.x), 8 * (8 * chunk->key.y + offset.y),
                                  8 * (8 * chunk->key.z + offset.z));
  const Resampled::Around around = from->About(low.array() + 4.0 * voxel_m, kBlockSide * voxel_m);
  if (around.all && !Field::Known(*around.all)) return;
  const BlockKind kind = chunk->Kind(block);
  if (around.all && kind == BlockKind::kUniform) {
    to->MakeUniform(chunk, block, FusedDistance(chunk->uniform.Get(block), *around.all), 0);
  } else if (around.finest == BlockKind::kFine || kind == BlockKind::kFine) {
    FuseCells<kBlockVoxels>(&to->MakeFine(chunk, block, 0), [&](int i) {
      return from->At(low + voxel_m * Vec3((i & 7) + 0.5, (i >> 3 & 7) + 0.5, (i >> 6) + 0.5));
    });
  } else {
    FuseCells<64>(&to->MakeCoarse(chunk, block, 0), [&](int i) {
      return from->At(low + 2.0 * voxel_m * Vec3((i & 3) + 0.5, (i >> 2 & 3) + 0.5, (i >> 4) + 0.5));
    });
  }
}

}  // namespace

Field::Value FusedDistance(Field::Value a, Field::Value b) {
  if (!Field::Known(a)) return b;
  if (!Field::Known(b)) return a;
  const int weight = a.weight + b.weight;
  const int sum = a.weight * a.distance + b.weight * b.distance;
  const double mean = static_cast<double>(sum) / weight;
  return {static_cast<int16_t>(std::lround(mean)), static_cast<uint8_t>(std::min(weight, Field::kMaxWeight))};
}

void FuseDistances(const TsdfOctree& from, const Pose& T_to_from, const std::map<uint64_t, BlockMask>& blocks,
                   TsdfOctree* to) {
  Resampled resampled(from, T_to_from.inverse());
  for (const auto& [code, mask] : blocks) {
    Chunk* const chunk = to->FindOrCreate(ChunkKeyOf(code));
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (mask.Test(block)) FuseBlock(&resampled, to, chunk, block);
    }
    to->CollapseEqual(chunk, mask, 0);
    to->Propagate(chunk, mask);
    if (!Field::NodeObserved(chunk->level6)) to->Erase(chunk->key);
  }
}

}  // namespace atlas::mapping
