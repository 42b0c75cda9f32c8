#include "mapping/meshing/block_samples.h"

#include <algorithm>

namespace atlas::mapping {
namespace {

/// Of the voxels [begin, end) that the cube takes from a neighbouring block at offset -1, 0 or 1.
struct Span {
  int begin, end;
};
template <typename Field>
Span TakenFrom(int offset) {
  using Samples = BlockSamples<Field>;
  return {std::max(Samples::kBegin - 8 * offset, 0), std::min(Samples::kEnd - 8 * offset, kBlockSide)};
}

}  // namespace

template <typename Field>
void BlockSamples<Field>::Gather(const Octree<Field>& map, const ChunkNeighbours<Field>& around, int block) {
  const NodeKey at = BlockOffset(block);
  for (int i = 0; i < 27; ++i) {
    const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
    const int bx = at.x + dx, by = at.y + dy, bz = at.z + dz;
    const auto* chunk =
        around[static_cast<size_t>((bx >> 3) + 1 + 3 * ((by >> 3) + 1) + 9 * ((bz >> 3) + 1))];
    const Span sx = TakenFrom<Field>(dx), sy = TakenFrom<Field>(dy), sz = TakenFrom<Field>(dz);
    const auto copy = [&](const auto& get) {
      for (int z = sz.begin; z < sz.end; ++z) {
        for (int y = sy.begin; y < sy.end; ++y) {
          const int first =
              (sx.begin + 8 * dx - kBegin) + kRow * ((y + 8 * dy - kBegin) + kRow * (z + 8 * dz - kBegin));
          float* to = &sample_[static_cast<size_t>(first)];
          for (int x = sx.begin; x < sx.end; ++x) *to++ = get(x, y, z);
        }
      }
    };
    const int neighbour = BlockIndex(bx, by, bz);
    const BlockKind kind = chunk == nullptr ? BlockKind::kUniform : chunk->Kind(neighbour);
    scale_[static_cast<size_t>(i)] = kind == BlockKind::kCoarse ? 2 : 1;
    if (kind == BlockKind::kFine) {
      const auto& leaf = map.Fine(*chunk, neighbour);
      copy([&leaf](int x, int y, int z) { return SampleOf(leaf.Get(x + 8 * y + 64 * z)); });
    } else if (kind == BlockKind::kCoarse) {
      const auto& leaf = map.Coarse(*chunk, neighbour);
      copy([&leaf](int x, int y, int z) {
        return SampleOf(leaf.Get((x >> 1) + 4 * (y >> 1) + 16 * (z >> 1)));
      });
    } else {
      const float value = SampleOf(chunk == nullptr ? Field::Unknown() : chunk->uniform.Get(neighbour));
      copy([value](int, int, int) { return value; });
    }
  }
}

template <typename Field>
float BlockSamples<Field>::Between(const core::Vec3f& p) const {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y())),
            z = static_cast<int>(std::floor(p.z()));
  const float u = p.x() - static_cast<float>(x), v = p.y() - static_cast<float>(y),
              w = p.z() - static_cast<float>(z);
  float sum = 0.0f, weight = 0.0f;
  for (int i = 0; i < 8; ++i) {
    const int a = i & 1, b = i >> 1 & 1, c = i >> 2;
    const float s = At(x + a, y + b, z + c);
    if (!IsKnown(s)) continue;
    const float share = (a != 0 ? u : 1 - u) * (b != 0 ? v : 1 - v) * (c != 0 ? w : 1 - w);
    sum += share * s;
    weight += share;
  }
  return weight > 0.0f ? sum / weight : std::nanf("");
}

/// Over the known voxels of the 2 x 2 x 2 cell at (2 cx, 2 cy, 2 cz).
template <typename Field>
float BlockSamples<Field>::CellMean(int cx, int cy, int cz) const {
  float sum = 0.0f;
  int known = 0;
  for (int i = 0; i < 8; ++i) {
    const float s = At(2 * cx + (i & 1), 2 * cy + (i >> 1 & 1), 2 * cz + (i >> 2));
    if (!IsKnown(s)) continue;
    sum += s;
    ++known;
  }
  return known == 0 ? std::nanf("") : sum / static_cast<float>(known);
}

template <typename Field>
float BlockSamples<Field>::Slope(int x, int y, int z) const {
  const float own = At(x, y, z);
  float sum = 0.0f, weight = 0.0f;
  for (int i = 0; i < 8; ++i) {
    // A voxel's centre lies a quarter of a cell off its cell's centre.
    const int far_x = i & 1, far_y = i >> 1 & 1, far_z = i >> 2;
    const float s =
        CellMean((x >> 1) + far_x * ((x & 1) != 0 ? 1 : -1), (y >> 1) + far_y * ((y & 1) != 0 ? 1 : -1),
                 (z >> 1) + far_z * ((z & 1) != 0 ? 1 : -1));
    if (!IsKnown(s)) continue;
    const float w =
        (far_x != 0 ? 0.25f : 0.75f) * (far_y != 0 ? 0.25f : 0.75f) * (far_z != 0 ? 0.25f : 0.75f);
    sum += w * s;
    weight += w;
  }
  constexpr float kBesideZero = 1e-3f;
  const float slope = sum / weight;
  return IsInside(own) ? std::min(slope, -kBesideZero) : std::max(slope, kBesideZero);
}

template class BlockSamples<OccupancyField>;
template class BlockSamples<TsdfField>;

}  // namespace atlas::mapping
