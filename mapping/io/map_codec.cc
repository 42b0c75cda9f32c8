#include "mapping/io/map_codec.h"

#include <bit>

namespace atlas::mapping {
namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they lie in memory");
static_assert(sizeof(BlockMask) == 64);

template <int N>
bool AnyKnown(const OccupancyField::Cells<N>& cells) {
  uint8_t any = 0;
  for (int i = 0; i < N; ++i) any |= static_cast<uint8_t>(cells.log_odds[i]);
  return any != 0;
}

template <int N>
bool AnyKnown(const TsdfField::Cells<N>& cells) {
  uint8_t any = 0;
  for (int i = 0; i < N; ++i) any |= cells.weight[i];
  return any != 0;
}

template <typename T>
void AppendRaw(const T* values, int count, std::string* out) {
  out->append(reinterpret_cast<const char*>(values), static_cast<size_t>(count) * sizeof(T));
}

template <int N>
void AppendCells(const OccupancyField::Cells<N>& cells, std::string* out) {
  AppendRaw(cells.log_odds, N, out);
}

template <int N>
void AppendCells(const TsdfField::Cells<N>& cells, std::string* out) {
  int16_t distance[N];  // the distance of what has no weight means nothing
  for (int i = 0; i < N; ++i) distance[i] = cells.weight[i] != 0 ? cells.distance[i] : int16_t{0};
  AppendRaw(distance, N, out);
  AppendRaw(cells.weight, N, out);
}

template <typename T>
void ReadRaw(core::ByteReader* reader, int count, T* values) {
  const std::string_view bytes = reader->Take(static_cast<size_t>(count) * sizeof(T));
  std::memcpy(values, bytes.data(), bytes.size());
}

template <int N>
void ReadCells(core::ByteReader* reader, OccupancyField::Cells<N>* cells) {
  ReadRaw(reader, N, cells->log_odds);
  for (int i = 0; i < N; ++i) {
    if (cells->log_odds[i] == OccupancyField::kNoneObserved) {
      reader->Fail(fmt::format("log-odds {} of a voxel, must be -127 to 127", cells->log_odds[i]));
    }
  }
}

template <int N>
void ReadCells(core::ByteReader* reader, TsdfField::Cells<N>* cells) {
  ReadRaw(reader, N, cells->distance);
  ReadRaw(reader, N, cells->weight);
}

template <typename Visit>
void ForEachBlock(const ChunkContent& content, const Visit& visit) {
  for (int block = 0; block < kChunkBlocks; ++block) {
    if (content.fine.Test(block)) {
      visit(block, BlockKind::kFine);
    } else if (content.coarse.Test(block)) {
      visit(block, BlockKind::kCoarse);
    }
  }
}

/// Masks and uniform values; counts what is there.
template <typename Field>
ChunkContent ReadHead(core::ByteReader* reader, typename Field::template Cells<kChunkBlocks>* uniform) {
  ChunkContent content;
  ReadRaw(reader, 8, content.fine.bits.data());
  ReadRaw(reader, 8, content.coarse.bits.data());
  ReadCells(reader, uniform);
  for (int block = 0; block < kChunkBlocks; ++block) {
    const bool fine = content.fine.Test(block), coarse = content.coarse.Test(block);
    if (fine && coarse) reader->Fail(fmt::format("block {} is both fine and coarse, must be one", block));
    content.fine_count += fine;
    content.coarse_count += coarse;
    content.uniform_count += !fine && !coarse && Field::Known(uniform->Get(block));
  }
  return content;
}

}  // namespace

template <typename Field>
ChunkContent ContentOf(const Octree<Field>& map, const typename Octree<Field>::Chunk& chunk) {
  ChunkContent content;
  for (int block = 0; block < kChunkBlocks; ++block) {
    switch (chunk.Kind(block)) {
      case BlockKind::kUniform:
        content.uniform_count += Field::Known(chunk.uniform.Get(block));
        break;
      case BlockKind::kCoarse:
        if (AnyKnown(map.Coarse(chunk, block))) content.coarse.Set(block), ++content.coarse_count;
        break;
      case BlockKind::kFine:
        if (AnyKnown(map.Fine(chunk, block))) content.fine.Set(block), ++content.fine_count;
        break;
    }
  }
  return content;
}

template <typename Field>
void AppendChunk(const Octree<Field>& map, const typename Octree<Field>::Chunk& chunk, std::string* out) {
  const ChunkContent content = ContentOf(map, chunk);
  const int32_t key[3] = {chunk.key.x, chunk.key.y, chunk.key.z};
  AppendRaw(key, 3, out);
  AppendRaw(content.fine.bits.data(), 8, out);
  AppendRaw(content.coarse.bits.data(), 8, out);
  typename Field::template Cells<kChunkBlocks> uniform;
  for (int block = 0; block < kChunkBlocks; ++block) {
    const bool holds = chunk.Kind(block) == BlockKind::kUniform;
    uniform.Set(block, holds ? chunk.uniform.Get(block) : Field::Unknown());
  }
  AppendCells(uniform, out);
  ForEachBlock(content, [&](int block, BlockKind kind) {
    if (kind == BlockKind::kFine) {
      AppendCells(map.Fine(chunk, block), out);
    } else {
      AppendCells(map.Coarse(chunk, block), out);
    }
  });
}

template <typename Field>
ChunkContent ReadChunk(core::ByteReader* reader, uint64_t* first_code, Octree<Field>* map) {
  NodeKey key;
  key.x = reader->Next<int32_t>();
  key.y = reader->Next<int32_t>();
  key.z = reader->Next<int32_t>();
  for (const int32_t k : {key.x, key.y, key.z}) {
    if (k < -kChunkKeyOffset || k >= kChunkKeyOffset) {
      reader->Fail(
          fmt::format("chunk coordinate {}, must be {} to {}", k, -kChunkKeyOffset, kChunkKeyOffset - 1));
    }
  }
  if (ChunkCode(key) < *first_code) {
    reader->Fail(fmt::format("chunk ({}, {}, {}) is out of order: codes must ascend", key.x, key.y, key.z));
  }
  *first_code = ChunkCode(key) + 1;

  typename Field::template Cells<kChunkBlocks> uniform;
  const ChunkContent content = ReadHead<Field>(reader, &uniform);
  typename Octree<Field>::Chunk* chunk = map->FindOrCreate(key);
  chunk->uniform = uniform;
  ForEachBlock(content, [&](int block, BlockKind kind) {
    if (kind == BlockKind::kFine) {
      ReadCells(reader, &map->MakeFine(chunk, block, 0));
    } else {
      ReadCells(reader, &map->MakeCoarse(chunk, block, 0));
    }
  });
  BlockMask all;
  all.bits.fill(~uint64_t{0});
  map->Propagate(chunk, all);
  chunk->dirty = all;
  return content;
}

#define ATLAS_INSTANTIATE(Field)                                                              \
  template ChunkContent ContentOf(const Octree<Field>&, const Octree<Field>::Chunk&);         \
  template void AppendChunk(const Octree<Field>&, const Octree<Field>::Chunk&, std::string*); \
  template ChunkContent ReadChunk(core::ByteReader*, uint64_t*, Octree<Field>*);
ATLAS_INSTANTIATE(OccupancyField)
ATLAS_INSTANTIATE(TsdfField)
#undef ATLAS_INSTANTIATE

}  // namespace atlas::mapping
