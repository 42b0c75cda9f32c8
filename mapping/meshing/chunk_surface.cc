#include "mapping/meshing/chunk_surface.h"

#include <limits>

#include "mapping/meshing/surface_vertex.h"

namespace atlas::mapping {
namespace {

constexpr uint32_t kNoVertex = std::numeric_limits<uint32_t>::max();
constexpr int kCorners = kBlockSide + 1;     ///< a side of a block's cells
constexpr int kEdgeSide = kChunkSide + 1;    ///< lower ends of a chunk's edges a side
constexpr int kBlocksSide = kBlockSide + 1;  ///< blocks of the chunk and the next

bool MayHoldInside(const OccupancyField::Node& node) {
  return node.max > 0;
}
bool MayHoldInside(const TsdfField::Node& node) {
  return node.min_distance <= 0;
}

/// Corner states of a block's cells, a bit a voxel along x.
struct CornerRows {
  std::array<uint32_t, kCorners * kCorners> inside, known;

  template <typename Field>
  explicit CornerRows(const BlockSamples<Field>& samples) {
    for (int z = 0; z < kCorners; ++z) {
      for (int y = 0; y < kCorners; ++y) {
        uint32_t in = 0, seen = 0;
        for (int x = 0; x < kCorners; ++x) {
          const float s = samples.At(x, y, z);
          in |= static_cast<uint32_t>(IsInside(s)) << x;
          seen |= static_cast<uint32_t>(IsKnown(s)) << x;
        }
        inside[static_cast<size_t>(y + kCorners * z)] = in;
        known[static_cast<size_t>(y + kCorners * z)] = seen;
      }
    }
  }
  /// The four rows that bound the cells at (y, z).
  static std::array<size_t, 4> RowsOf(int y, int z) {
    const auto row = static_cast<size_t>(y + kCorners * z);
    return {row, row + 1, row + kCorners, row + kCorners + 1};
  }
  /// Cells along x that are known at all corners and cross the surface.
  uint32_t Crossed(const std::array<size_t, 4>& rows) const {
    const uint32_t seen = known[rows[0]] & known[rows[1]] & known[rows[2]] & known[rows[3]];
    const uint32_t any = inside[rows[0]] | inside[rows[1]] | inside[rows[2]] | inside[rows[3]];
    const uint32_t all = inside[rows[0]] & inside[rows[1]] & inside[rows[2]] & inside[rows[3]];
    return (seen & seen >> 1) & (any | any >> 1) & ~(all & all >> 1) & 0xffu;
  }
  unsigned CaseOf(const std::array<size_t, 4>& rows, int x) const {
    unsigned bits = 0;
    for (size_t i = 0; i < 4; ++i) bits |= (inside[rows[i]] >> x & 3u) << (2 * i);
    return bits;
  }
};

}  // namespace

template <typename Field>
ChunkMesher<Field>::ChunkMesher(const Octree<Field>& map, bool undo_shift)
    : map_(map),
      undo_shift_(undo_shift),
      vertex_on_edge_(size_t{3} * kEdgeSide * kEdgeSide * kEdgeSide, kNoVertex) {}

template <typename Field>
ChunkSurface ChunkMesher<Field>::Extract(const typename Octree<Field>::Chunk& chunk) {
  ChunkSurface surface;
  chunk_ = chunk.key;
  for (int i = 0; i < 27; ++i) {
    around_[static_cast<size_t>(i)] =
        map_.Find(NodeKey{chunk_.x + i % 3 - 1, chunk_.y + i / 3 % 3 - 1, chunk_.z + i / 9 - 1});
  }
  bool may_cross = false;
  for (const int i : {13, 14, 16, 17, 22, 23, 25, 26}) {
    const auto* c = around_[static_cast<size_t>(i)];
    may_cross = may_cross || (c != nullptr && MayHoldInside(c->level6));
  }
  if (!may_cross) return surface;
  MarkSolidBlocks();
  for (int block = 0; block < kChunkBlocks; ++block) {
    if (MayCross(block)) ExtractBlock(block, &surface);
  }
  for (const size_t edge : edges_set_) vertex_on_edge_[edge] = kNoVertex;
  edges_set_.clear();
  return surface;
}

template <typename Field>
void ChunkMesher<Field>::MarkSolidBlocks() {
  size_t i = 0;
  for (int z = 0; z < kBlocksSide; ++z) {
    for (int y = 0; y < kBlocksSide; ++y) {
      for (int x = 0; x < kBlocksSide; ++x) {
        const auto* c = around_[static_cast<size_t>(13 + (x >> 3) + 3 * (y >> 3) + 9 * (z >> 3))];
        solid_[i++] =
            c != nullptr && MayHoldInside(c->level6) && MayHoldInside(c->BlockNode(BlockIndex(x, y, z)));
      }
    }
  }
}

template <typename Field>
bool ChunkMesher<Field>::MayCross(int block) const {
  const NodeKey at = BlockOffset(block);
  for (int i = 0; i < 8; ++i) {
    const int x = at.x + (i & 1), y = at.y + (i >> 1 & 1), z = at.z + (i >> 2);
    if (solid_[static_cast<size_t>(x + kBlocksSide * (y + kBlocksSide * z))]) return true;
  }
  return false;
}

template <typename Field>
void ChunkMesher<Field>::ExtractBlock(int block, ChunkSurface* surface) {
  block_ = BlockOffset(block);
  samples_.Gather(map_, around_, block);
  const CornerRows corners(samples_);
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      const std::array<size_t, 4> rows = CornerRows::RowsOf(y, z);
      for (uint32_t cells = corners.Crossed(rows); cells != 0; cells &= cells - 1) {
        const int x = __builtin_ctz(cells);
        ExtractCell({x, y, z}, corners.CaseOf(rows, x), surface);
      }
    }
  }
}

template <typename Field>
void ChunkMesher<Field>::ExtractCell(const NodeKey& cell, unsigned inside, ChunkSurface* surface) {
  const CubeCase& cube = table_.Case(inside);
  for (size_t i = 0; i < static_cast<size_t>(cube.count); ++i) {
    std::array<uint32_t, 3> triangle;
    for (size_t k = 0; k < 3; ++k) {
      const CubeEdge& edge = table_.Edge(cube.triangle[i][k]);
      const NodeKey voxel = {cell.x + edge.corner[0], cell.y + edge.corner[1], cell.z + edge.corner[2]};
      triangle[k] = VertexOn(voxel, edge.axis, surface);
    }
    surface->mesh.triangles.push_back(triangle);
  }
}

template <typename Field>
uint32_t ChunkMesher<Field>::VertexOn(const NodeKey& voxel, int axis, ChunkSurface* surface) {
  const NodeKey in_chunk = {8 * block_.x + voxel.x, 8 * block_.y + voxel.y, 8 * block_.z + voxel.z};
  const auto edge =
      static_cast<size_t>(axis + 3 * (in_chunk.x + kEdgeSide * (in_chunk.y + kEdgeSide * in_chunk.z)));
  uint32_t& vertex = vertex_on_edge_[edge];
  if (vertex != kNoVertex) return vertex;
  vertex = static_cast<uint32_t>(surface->mesh.vertices.size());
  edges_set_.push_back(edge);
  const NodeKey in_map = {kChunkSide * chunk_.x + in_chunk.x, kChunkSide * chunk_.y + in_chunk.y,
                          kChunkSide * chunk_.z + in_chunk.z};
  const core::Vec3f p =
      SurfaceVertex(samples_, voxel, axis, undo_shift_) -
      core::Vec3f(static_cast<float>(voxel.x), static_cast<float>(voxel.y), static_cast<float>(voxel.z));
  surface->mesh.vertices.push_back(
      (map_.CenterOf(in_map) + map_.resolution_m() * p.cast<double>()).template cast<float>());
  const auto on_border = [](int i) { return i == 0 || i == kChunkSide; };
  if (on_border(in_chunk.x) || on_border(in_chunk.y) || on_border(in_chunk.z))
    surface->shared.push_back({in_map, axis, vertex});
  return vertex;
}

template class ChunkMesher<OccupancyField>;
template class ChunkMesher<TsdfField>;

}  // namespace atlas::mapping
