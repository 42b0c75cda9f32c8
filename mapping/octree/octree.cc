#include "mapping/octree/octree.h"

#include <algorithm>
#include <cassert>
#include <stdexcept>

namespace atlas::mapping {
namespace {

/// The node of a block whose cells are held one by one. Vectorises.
template <int N>
OccupancyField::Node NodeOfOccupancy(const OccupancyField::Cells<N>& cells) {
  int max = OccupancyField::kNoneObserved;
  int zeros = 0;
  for (int i = 0; i < N; ++i) {
    const int v = cells.log_odds[i];
    zeros += v == 0;
    max = std::max(max, v == 0 ? OccupancyField::kNoneObserved : v);
  }
  return {static_cast<int8_t>(max), zeros > 0};
}

template <typename Field, int N>
typename Field::Node Summarise(const typename Field::template Cells<N>& cells) {
  if constexpr (std::is_same_v<Field, OccupancyField>) {
    return NodeOfOccupancy<N>(cells);
  } else {
    return TsdfField::Summarise(cells).node;
  }
}

template <typename Field>
typename Field::Node MergeEight(const typename Field::Node* child) {
  const auto a = Field::Merge(Field::Merge(child[0], child[1]), Field::Merge(child[2], child[3]));
  const auto b = Field::Merge(Field::Merge(child[4], child[5]), Field::Merge(child[6], child[7]));
  return Field::Merge(a, b);
}

template <int N, typename Cells>
bool AllEqual(const Cells& cells) {
  for (int i = 1; i < N; ++i) {
    if (!(cells.Get(i) == cells.Get(0))) return false;
  }
  return true;
}

template <typename Visit>
void ForEachBit(const BlockMask& mask, const Visit& visit) {
  for (int word = 0; word < 8; ++word) {
    for (uint64_t bits = mask.bits[static_cast<size_t>(word)]; bits != 0; bits &= bits - 1) {
      visit(64 * word + __builtin_ctzll(bits));
    }
  }
}

}  // namespace

template <typename Field>
Octree<Field>::Octree(double resolution_m)
    : resolution_m_(resolution_m),
      inverse_resolution_(1.0 / resolution_m),
      chunk_pool_(std::make_unique<ChunkPool>()),
      details_(std::make_unique<DetailPool>()),
      fine_(std::make_unique<SlabPool<FineLeaf>>()),
      coarse_(std::make_unique<SlabPool<CoarseLeaf>>()) {
  if (!(resolution_m >= 0.001 && resolution_m <= 10.0)) {
    throw std::invalid_argument("octree resolution outside 0.001 to 10 m");
  }
}

template <typename Field>
Octree<Field>::Octree(Octree&&) noexcept = default;
template <typename Field>
Octree<Field>& Octree<Field>::operator=(Octree&&) noexcept = default;
template <typename Field>
Octree<Field>::~Octree() = default;

template <typename Field>
Octree<Field> Octree<Field>::Clone() const {
  Octree copy(resolution_m_);
  for (const Chunk* from : Chunks()) {
    Chunk* to = copy.FindOrCreate(from->key);
    to->uniform = from->uniform;
    ForEachBit(from->fine, [&](int block) { copy.MakeFine(to, block, 0) = Fine(*from, block); });
    ForEachBit(from->coarse, [&](int block) { copy.MakeCoarse(to, block, 0) = Coarse(*from, block); });
    if (from->detail != nullptr) copy.DetailOf(to, 0)->block = from->detail->block;
    to->level4 = from->level4;
    to->level5 = from->level5;
    to->level6 = from->level6;
    to->dirty = {};
  }
  return copy;
}

template <typename Field>
typename Octree<Field>::Chunk* Octree<Field>::FindOrCreate(const NodeKey& chunk) {
  if (Chunk* const found = chunks_.Find(chunk)) return found;
  const uint32_t cell = chunk_pool_->Allocate(0);
  Chunk* const created = new (&(*chunk_pool_)[cell]) Chunk();
  created->cell = cell;
  created->key = chunk;
  created->uniform.Fill(Field::Unknown());
  chunks_.Insert(chunk, created);
  return created;
}

template <typename Field>
void Octree<Field>::Erase(const NodeKey& key, int worker) {
  Chunk* chunk = Find(key);
  if (chunk == nullptr) return;
  ForEachBit(chunk->fine,
             [&](int block) { fine_->Free(chunk->detail->leaf[static_cast<size_t>(block)], worker); });
  ForEachBit(chunk->coarse,
             [&](int block) { coarse_->Free(chunk->detail->leaf[static_cast<size_t>(block)], worker); });
  if (chunk->detail != nullptr) details_->Free(chunk->detail_cell, worker);
  chunk_pool_->Free(chunk->cell, 0);
  chunks_.Erase(key);
}

template <typename Field>
std::vector<const typename Octree<Field>::Chunk*> Octree<Field>::Chunks() const {
  std::vector<std::pair<uint64_t, const Chunk*>> order;
  order.reserve(chunks_.size());
  chunks_.ForEach([&](const Chunk* chunk) { order.emplace_back(ChunkCode(chunk->key), chunk); });
  std::sort(order.begin(), order.end());
  std::vector<const Chunk*> chunks;
  chunks.reserve(order.size());
  for (const auto& [code, chunk] : order) chunks.push_back(chunk);
  return chunks;
}

template <typename Field>
typename Field::Value Octree<Field>::At(const NodeKey& voxel) const {
  const Chunk* chunk = Find(voxel.Up(kChunkLevel));
  if (chunk == nullptr) return Field::Unknown();
  return ValueIn(*chunk, BlockIndexOf(voxel), VoxelIndex(voxel.x, voxel.y, voxel.z));
}

template <typename Field>
void Octree<Field>::Set(const NodeKey& voxel, Value value, int worker) {
  Chunk* chunk = FindOrCreate(voxel.Up(kChunkLevel));
  const int block = BlockIndexOf(voxel);
  MakeFine(chunk, block, worker).Set(VoxelIndex(voxel.x, voxel.y, voxel.z), value);
  chunk->dirty.Set(block);
}

template <typename Field>
typename Octree<Field>::Chunk::Detail* Octree<Field>::DetailOf(Chunk* chunk, int worker) {
  if (chunk->detail == nullptr) {
    chunk->detail_cell = details_->Allocate(worker);
    chunk->detail = new (&(*details_)[chunk->detail_cell]) typename Chunk::Detail();
  }
  return chunk->detail;
}

template <typename Field>
typename Octree<Field>::CoarseLeaf& Octree<Field>::MakeCoarse(Chunk* chunk, int block, int worker) {
  assert(!chunk->fine.Test(block));
  if (!chunk->coarse.Test(block)) {
    const uint32_t leaf = coarse_->Allocate(worker);
    (*coarse_)[leaf].Fill(chunk->uniform.Get(block));
    DetailOf(chunk, worker)->leaf[static_cast<size_t>(block)] = leaf;
    chunk->coarse.Set(block);
  }
  return Coarse(chunk, block);
}

template <typename Field>
typename Octree<Field>::FineLeaf& Octree<Field>::MakeFine(Chunk* chunk, int block, int worker) {
  if (chunk->fine.Test(block)) return Fine(chunk, block);
  const uint32_t leaf = fine_->Allocate(worker);
  FineLeaf& fine = (*fine_)[leaf];
  Expand(*chunk, block, &fine);
  typename Chunk::Detail* detail = DetailOf(chunk, worker);
  if (chunk->coarse.Test(block)) {
    coarse_->Free(detail->leaf[static_cast<size_t>(block)], worker);
    chunk->coarse.Clear(block);
  }
  detail->leaf[static_cast<size_t>(block)] = leaf;
  chunk->fine.Set(block);
  return fine;
}

template <typename Field>
void Octree<Field>::MakeUniform(Chunk* chunk, int block, Value value, int worker) {
  if (chunk->fine.Test(block)) {
    fine_->Free(chunk->detail->leaf[static_cast<size_t>(block)], worker);
    chunk->fine.Clear(block);
  } else if (chunk->coarse.Test(block)) {
    coarse_->Free(chunk->detail->leaf[static_cast<size_t>(block)], worker);
    chunk->coarse.Clear(block);
  }
  chunk->uniform.Set(block, value);
}

template <typename Field>
void Octree<Field>::Expand(const Chunk& chunk, int block, FineLeaf* out) const {
  switch (chunk.Kind(block)) {
    case BlockKind::kUniform:
      out->Fill(chunk.uniform.Get(block));
      return;
    case BlockKind::kCoarse: {
      const CoarseLeaf& coarse = Coarse(chunk, block);
      for (int i = 0; i < kBlockVoxels; ++i) out->Set(i, coarse.Get(CellOfVoxel(i)));
      return;
    }
    case BlockKind::kFine:
      *out = Fine(chunk, block);
      return;
  }
}

template <typename Field>
void Octree<Field>::Propagate(Chunk* chunk, const BlockMask& which) {
  ForEachBit(which, [&](int block) {
    if (chunk->fine.Test(block)) {
      chunk->detail->block[static_cast<size_t>(block)] = Summarise<Field, kBlockVoxels>(Fine(chunk, block));
    } else if (chunk->coarse.Test(block)) {
      chunk->detail->block[static_cast<size_t>(block)] = Summarise<Field, 64>(Coarse(chunk, block));
    }
  });
  PropagateAbove(chunk, which);
}

template <typename Field>
void Octree<Field>::PropagateAbove(Chunk* chunk, const BlockMask& which) {
  uint64_t parents = 0;  // a bit a level 4 node
  for (size_t word = 0; word < 8; ++word) {
    for (int byte = 0; byte < 8; ++byte) {
      if (which.bits[word] >> (8 * byte) & 0xff)
        parents |= uint64_t{1} << (8 * word + static_cast<size_t>(byte));
    }
  }
  if (parents == 0) return;
  for (uint64_t bits = parents; bits != 0; bits &= bits - 1) {
    const int node = __builtin_ctzll(bits);
    std::array<Node, 8> child;
    for (int i = 0; i < 8; ++i) child[static_cast<size_t>(i)] = chunk->BlockNode(8 * node + i);
    chunk->level4[static_cast<size_t>(node)] = MergeEight<Field>(child.data());
  }
  for (size_t i = 0; i < 8; ++i) chunk->level5[i] = MergeEight<Field>(chunk->level4.data() + 8 * i);
  chunk->level6 = MergeEight<Field>(chunk->level5.data());
}

template <typename Field>
void Octree<Field>::CollapseEqual(Chunk* chunk, const BlockMask& which, int worker) {
  ForEachBit(which, [&](int block) {
    if (chunk->fine.Test(block)) {
      const FineLeaf& leaf = Fine(chunk, block);
      if (AllEqual<kBlockVoxels>(leaf)) MakeUniform(chunk, block, leaf.Get(0), worker);
    } else if (chunk->coarse.Test(block)) {
      const CoarseLeaf& leaf = Coarse(chunk, block);
      if (AllEqual<64>(leaf)) MakeUniform(chunk, block, leaf.Get(0), worker);
    }
  });
}

template <typename Field>
std::vector<std::pair<NodeKey, BlockMask>> Octree<Field>::TakeChanges() {
  std::vector<std::pair<uint64_t, Chunk*>> order;
  chunks_.ForEach([&](Chunk* chunk) {
    if (chunk->dirty.Any()) order.emplace_back(ChunkCode(chunk->key), chunk);
  });
  std::sort(order.begin(), order.end());
  std::vector<std::pair<NodeKey, BlockMask>> changes;
  changes.reserve(order.size());
  for (const auto& [code, chunk] : order) {
    changes.emplace_back(chunk->key, chunk->dirty);
    chunk->dirty = BlockMask{};
  }
  return changes;
}

template <typename Field>
void Octree<Field>::SetWorkers(int workers) {
  details_->SetWorkers(workers);
  fine_->SetWorkers(workers);
  coarse_->SetWorkers(workers);
}

template <typename Field>
size_t Octree<Field>::Bytes() const {
  size_t bytes = sizeof(*this) + chunks_.Bytes() + chunks_.size() * sizeof(Chunk);
  chunks_.ForEach([&](const Chunk* chunk) {
    if (chunk->detail) bytes += sizeof(typename Chunk::Detail);
  });
  return bytes + fine_->in_use() * sizeof(FineLeaf) + coarse_->in_use() * sizeof(CoarseLeaf);
}

template <typename Field>
typename Octree<Field>::Counts Octree<Field>::Count() const {
  Counts counts{chunks_.size(), fine_->in_use(), coarse_->in_use(), 0};
  chunks_.ForEach([&](const Chunk* chunk) {
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (chunk->Kind(block) != BlockKind::kUniform) continue;
      counts.uniform_known += Field::Known(chunk->uniform.Get(block));
    }
  });
  return counts;
}

template class Octree<OccupancyField>;
template class Octree<TsdfField>;

}  // namespace atlas::mapping
