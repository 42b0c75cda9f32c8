#include "mapping/atlas/distance_states.h"

namespace atlas::mapping {
namespace {

using Distance = TsdfField::Value;
using States = OccupancyField;

int8_t StateValueOf(Distance v) {
  constexpr int kMiddle = States::kPlaces / 2;
  constexpr int kOccupied = (States::kMax & ~(States::kPlaces - 1)) | kMiddle;
  if (!TsdfField::Known(v)) return States::Unknown();
  return static_cast<int8_t>(TsdfField::Occupied(v) ? kOccupied : States::kMin);
}

template <int N, typename From, typename To>
void Tell(const From& distances, To* states) {
  for (int i = 0; i < N; ++i) states->Set(i, StateValueOf(distances.Get(i)));
}

void TellBlock(const TsdfOctree& distances, const TsdfOctree::Chunk& from, int block, OccupancyOctree* tree,
               OccupancyOctree::Chunk* to) {
  const BlockKind kind = from.Kind(block);
  if (to->Kind(block) > kind) tree->MakeUniform(to, block, States::Unknown(), 0);
  switch (kind) {
    case BlockKind::kUniform:
      tree->MakeUniform(to, block, StateValueOf(from.uniform.Get(block)), 0);
      break;
    case BlockKind::kCoarse:
      Tell<64>(distances.Coarse(from, block), &tree->MakeCoarse(to, block, 0));
      break;
    case BlockKind::kFine:
      Tell<kBlockVoxels>(distances.Fine(from, block), &tree->MakeFine(to, block, 0));
      break;
  }
}

}  // namespace

void TellStates(const TsdfOctree& distances, const NodeKey& chunk, const BlockMask& blocks,
                OccupancyOctree* tree) {
  const TsdfOctree::Chunk* const from = distances.Find(chunk);
  if (from == nullptr) {
    tree->Erase(chunk);
    return;
  }
  OccupancyOctree::Chunk* const to = tree->FindOrCreate(chunk);
  for (int block = 0; block < kChunkBlocks; ++block) {
    if (blocks.Test(block)) TellBlock(distances, *from, block, tree, to);
  }
  tree->CollapseEqual(to, blocks, 0);
  tree->Propagate(to, blocks);
}

OccupancyOctree StatesOf(const TsdfOctree& distances) {
  OccupancyOctree tree(distances.resolution_m());
  BlockMask all;
  all.bits.fill(~uint64_t{0});
  for (const TsdfOctree::Chunk* chunk : distances.Chunks()) TellStates(distances, chunk->key, all, &tree);
  tree.TakeChanges();
  return tree;
}

}  // namespace atlas::mapping
