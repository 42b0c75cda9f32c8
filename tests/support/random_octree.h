// Octrees of random content at all scales, and the plain map of voxels that they should equal.
#pragma once

#include <map>
#include <tuple>

#include "core/rng.h"
#include "mapping/octree/octree.h"

namespace atlas::tests {

using mapping::NodeKey;

struct KeyLess {
  bool operator()(const NodeKey& a, const NodeKey& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};
template <typename Field>
using VoxelMap = std::map<NodeKey, typename Field::Value, KeyLess>;

template <typename Field>
typename Field::Value RandomValue(core::Rng* rng) {
  if constexpr (std::is_same_v<Field, mapping::OccupancyField>) {
    return static_cast<int8_t>(rng->UniformInt(4) == 0 ? 1 + rng->UniformInt(70) : -1 - rng->UniformInt(40));
  } else {
    return {
        static_cast<int16_t>(rng->UniformInt(4) == 0 ? -rng->UniformInt(3000) : 1 + rng->UniformInt(3000)),
        static_cast<uint8_t>(1 + rng->UniformInt(mapping::TsdfField::kMaxWeight))};
  }
}

/// Sets every voxel of a box of voxels in both.
template <typename Field>
void FillVoxels(const NodeKey& first, int side, typename Field::Value value, mapping::Octree<Field>* tree,
                VoxelMap<Field>* voxels) {
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const NodeKey key{first.x + x, first.y + y, first.z + z};
        tree->Set(key, value);
        (*voxels)[key] = value;
      }
    }
  }
}

/// Voxels, 2^3 cells, blocks, level 4 and 5 nodes of random values around the origin, within `reach` voxels;
/// equal blocks collapsed, some blocks made coarse, summaries current.
template <typename Field>
void FillAtRandom(uint64_t seed, int reach, mapping::Octree<Field>* tree, VoxelMap<Field>* voxels) {
  core::Rng rng(seed);
  const auto corner = [&](int level) {
    const int n = 2 * reach >> level;
    const auto draw = [&] { return (rng.UniformInt(n) - n / 2) * (1 << level); };
    const int x = draw(), y = draw();
    return NodeKey{x, y, draw()};
  };
  for (int i = 0; i < 8; ++i) {
    typename Field::Value value = RandomValue<Field>(&rng);
    while (!Field::Free(value)) value = RandomValue<Field>(&rng);
    FillVoxels<Field>(corner(5), 32, value, tree, voxels);
  }
  for (int i = 0; i < 4; ++i) FillVoxels<Field>(corner(4), 16, RandomValue<Field>(&rng), tree, voxels);
  for (int i = 0; i < 80; ++i) FillVoxels<Field>(corner(3), 8, RandomValue<Field>(&rng), tree, voxels);
  for (int i = 0; i < 2000; ++i) FillVoxels<Field>(corner(1), 2, RandomValue<Field>(&rng), tree, voxels);
  for (int i = 0; i < 2000; ++i) FillVoxels<Field>(corner(0), 1, RandomValue<Field>(&rng), tree, voxels);
  for (const auto& [key, which] : tree->TakeChanges()) {
    auto* chunk = tree->Find(key);
    tree->CollapseEqual(chunk, which, 0);
    for (int block = 0; block < mapping::kChunkBlocks; block += 3) {  // uniform at a finer scale than needed
      if (which.Test(block) && !chunk->fine.Test(block)) tree->MakeCoarse(chunk, block, 0);
    }
    tree->Propagate(chunk, which);
  }
}

template <typename Field>
typename Field::Value ValueIn(const VoxelMap<Field>& voxels, const NodeKey& key) {
  const auto found = voxels.find(key);
  return found == voxels.end() ? Field::Unknown() : found->second;
}

}  // namespace atlas::tests
