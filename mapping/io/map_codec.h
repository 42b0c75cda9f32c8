// How map.atlas holds one chunk, before compression.
//
// Little endian: chunk key (3 int32), which blocks are fine and which coarse (64 bytes each), the values of
// the 512 uniform blocks (0 for others), then the leaves by ascending block: 64 values (coarse) or 512
// (fine). Values: log-odds as int8; or signed distances as int16, then weights as uint8.
#pragma once

#include <string>

#include "core/byte_reader.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// What a chunk stores, without what is unknown: leaves that hold nothing known count as uniform.
struct ChunkContent {
  BlockMask fine, coarse;
  size_t fine_count = 0, coarse_count = 0, uniform_count = 0;  ///< uniform: of known value
  bool any() const { return fine_count + coarse_count + uniform_count > 0; }
};
template <typename Field>
ChunkContent ContentOf(const Octree<Field>& map, const typename Octree<Field>::Chunk& chunk);

/// The greatest size of a chunk that AppendChunk writes.
template <typename Field>
constexpr size_t MaxChunkBytes() {
  constexpr size_t kValueBytes = std::is_same_v<Field, OccupancyField> ? 1 : 3;
  return 12 + 2 * sizeof(BlockMask) + kValueBytes * kChunkBlocks * (kBlockVoxels + 1);
}

template <typename Field>
void AppendChunk(const Octree<Field>& map, const typename Octree<Field>::Chunk& chunk, std::string* out);

/// Adds the chunk that comes next to the map, its summaries current and its blocks marked as written.
/// @param first_code  least Morton code allowed; one more than the chunk's afterwards.
/// @throws InputError for a chunk out of order or range, a block of two kinds, or a value that none has.
template <typename Field>
ChunkContent ReadChunk(core::ByteReader* reader, uint64_t* first_code, Octree<Field>* map);

}  // namespace atlas::mapping
