#include "mapping/octree/queries.h"

#include <cassert>

namespace atlas::mapping {
namespace {

using core::Vec3;

bool MayBeOccupied(const OccupancyField::Node& node) {
  return node.max > 0;
}
bool MayBeOccupied(const TsdfField::Node& node) {
  return TsdfField::NodeObserved(node) && node.min_distance <= 0;
}

/// The summary of the node at `level` (3 to 6) that holds a block.
template <typename Field>
typename Field::Node NodeAt(const typename Octree<Field>::Chunk& chunk, int block, int level) {
  switch (level) {
    case kBlockLevel:
      return chunk.BlockNode(block);
    case 4:
      return chunk.level4[static_cast<size_t>(block) >> 3];
    case 5:
      return chunk.level5[static_cast<size_t>(block) >> 6];
    default:
      return chunk.level6;
  }
}

/// The highest node around a block without an occupied voxel, or 0 where the block itself may hold one.
template <typename Field>
int LevelWithoutOccupied(const typename Octree<Field>::Chunk& chunk, int block) {
  for (int level = kChunkLevel; level >= kBlockLevel; --level) {
    if (!MayBeOccupied(NodeAt<Field>(chunk, block, level))) return level;
  }
  return 0;
}

enum class Overlap { kNone, kPartly, kWhole };

/// How the cells of `map` that a shape meets are: descends from chunks to voxels, no further than needed.
/// `Shape` has OverlapOf(key, level).
template <typename Field, typename Shape>
class StateSearch {
 public:
  using Chunk = typename Octree<Field>::Chunk;
  StateSearch(const Octree<Field>& map, const Shape& shape) : map_(map), shape_(shape) {}

  void AddChunk(const NodeKey& key) {
    if (state_ == CellState::kOccupied) return;
    const Chunk* chunk = map_.Find(key);
    if (chunk == nullptr) {
      if (state_ == CellState::kFree && MeetsAVoxel(key, kChunkLevel)) state_ = CellState::kUnknown;
    } else {
      AddNode(*chunk, 0, kChunkLevel);
    }
  }
  CellState state() const { return state_; }

 private:
  void AddNode(const Chunk& chunk, int first_block, int level) {
    const typename Field::Node node = NodeAt<Field>(chunk, first_block, level);
    const NodeKey at = BlockOffset(first_block);
    const int up = level - kBlockLevel;
    const NodeKey key{(8 * chunk.key.x + at.x) >> up, (8 * chunk.key.y + at.y) >> up,
                      (8 * chunk.key.z + at.z) >> up};
    const Overlap overlap = shape_.OverlapOf(key, level);
    if (overlap == Overlap::kNone) return;
    const bool occupied = MayBeOccupied(node);
    if (!occupied && (!node.any_unknown || state_ == CellState::kUnknown)) return;  // nothing to learn
    if (!occupied && !Field::NodeObserved(node)) {                                  // unknown throughout
      if (MeetsAVoxel(key, level)) state_ = CellState::kUnknown;
      return;
    }
    if (overlap == Overlap::kWhole) {
      state_ = occupied ? CellState::kOccupied : CellState::kUnknown;
      return;
    }
    if (level == kBlockLevel) {
      AddVoxels(chunk, first_block);
      return;
    }
    const int child_blocks = 1 << 3 * (level - 1 - kBlockLevel);
    for (int child = 0; child < 8 && state_ != CellState::kOccupied; ++child) {
      AddNode(chunk, first_block + child * child_blocks, level - 1);
    }
  }

  /// A node that the shape seems to meet may hold no voxel that it does meet.
  bool MeetsAVoxel(const NodeKey& key, int level) const {
    const Overlap overlap = shape_.OverlapOf(key, level);
    if (overlap != Overlap::kPartly || level == 0) return overlap != Overlap::kNone;
    for (int child = 0; child < 8; ++child) {
      if (MeetsAVoxel({2 * key.x + (child & 1), 2 * key.y + (child >> 1 & 1), 2 * key.z + (child >> 2)},
                      level - 1)) {
        return true;
      }
    }
    return false;
  }

  void AddVoxels(const Chunk& chunk, int block) {
    const NodeKey at = BlockOffset(block);
    const NodeKey base{8 * (8 * chunk.key.x + at.x), 8 * (8 * chunk.key.y + at.y),
                       8 * (8 * chunk.key.z + at.z)};
    for (int i = 0; i < kBlockVoxels; ++i) {
      const typename Field::Value value = ValueOf(chunk, block, i);
      if (Field::Free(value) || (!Field::Known(value) && state_ == CellState::kUnknown)) continue;
      const NodeKey key{base.x + (i & 7), base.y + (i >> 3 & 7), base.z + (i >> 6)};
      if (shape_.OverlapOf(key, 0) == Overlap::kNone) continue;
      state_ = Field::Known(value) ? CellState::kOccupied : CellState::kUnknown;
      if (state_ == CellState::kOccupied) return;
    }
  }

  typename Field::Value ValueOf(const Chunk& chunk, int block, int voxel) const {
    switch (chunk.Kind(block)) {
      case BlockKind::kUniform:
        return chunk.uniform.Get(block);
      case BlockKind::kCoarse:
        return map_.Coarse(chunk, block).Get(CellOfVoxel(voxel));
      case BlockKind::kFine:
        break;
    }
    return map_.Fine(chunk, block).Get(voxel);
  }

  const Octree<Field>& map_;
  const Shape& shape_;
  CellState state_ = CellState::kFree;
};

struct BoxShape {
  NodeKey lo, hi;  ///< voxels, inclusive
  Overlap OverlapOf(const NodeKey& key, int level) const {
    const int32_t k[3] = {key.x, key.y, key.z}, l[3] = {lo.x, lo.y, lo.z}, h[3] = {hi.x, hi.y, hi.z};
    bool whole = true;
    for (int a = 0; a < 3; ++a) {
      const int32_t first = k[a] << level, last = first + (1 << level) - 1;
      if (last < l[a] || first > h[a]) return Overlap::kNone;
      whole = whole && first >= l[a] && last <= h[a];
    }
    return whole ? Overlap::kWhole : Overlap::kPartly;
  }
};

struct CapsuleShape {
  Vec3 a, b;  ///< in voxels
  double radius;
  Overlap OverlapOf(const NodeKey& key, int level) const {
    const double side = 1 << level, half_diagonal = 0.5 * std::sqrt(3.0) * side;
    const Vec3 center = side * (Vec3(key.x, key.y, key.z).array() + 0.5);
    const Vec3 along = b - a;
    const double length_squared = along.squaredNorm();
    const double s =
        length_squared > 0.0 ? std::clamp((center - a).dot(along) / length_squared, 0.0, 1.0) : 0.0;
    const double distance = (center - a - s * along).norm();
    if (distance > radius + half_diagonal) return Overlap::kNone;
    return distance + half_diagonal <= radius ? Overlap::kWhole : Overlap::kPartly;
  }
};

template <typename Field, typename Shape>
CellState StateOf(const Octree<Field>& map, const Shape& shape, const NodeKey& lo, const NodeKey& hi) {
  StateSearch<Field, Shape> search(map, shape);
  const NodeKey first = lo.Up(kChunkLevel), last = hi.Up(kChunkLevel);
  for (int32_t z = first.z; z <= last.z; ++z) {
    for (int32_t y = first.y; y <= last.y; ++y) {
      for (int32_t x = first.x; x <= last.x; ++x) search.AddChunk({x, y, z});
    }
  }
  return search.state();
}

}  // namespace

template <typename Field>
std::optional<double> FirstOccupied(const Octree<Field>& map, const Vec3& origin, const Vec3& direction,
                                    double max_range_m) {
  RayWalker<Field> walker(map, origin, direction, max_range_m);
  while (!walker.done()) {
    int level = kChunkLevel;
    if (const auto* chunk = walker.chunk()) {
      const NodeKey& voxel = walker.voxel();
      const int block = BlockIndexOf(voxel);
      level = LevelWithoutOccupied<Field>(*chunk, block);
      if (level == 0) {
        const int index = VoxelIndex(voxel.x, voxel.y, voxel.z);
        const BlockKind kind = chunk->Kind(block);
        const typename Field::Value value = kind == BlockKind::kUniform ? chunk->uniform.Get(block)
                                            : kind == BlockKind::kCoarse
                                                ? map.Coarse(*chunk, block).Get(CellOfVoxel(index))
                                                : map.Fine(*chunk, block).Get(index);
        if (Field::Occupied(value)) return walker.t();
        level = kind == BlockKind::kCoarse ? 1 : 0;
      }
    }
    walker.Leave(level);
  }
  return std::nullopt;
}

template <typename Field>
CellState StateOfBox(const Octree<Field>& map, const core::Box3& box) {
  const BoxShape shape{map.KeyAt(box.min), map.KeyAt(box.max)};
  return StateOf(map, shape, shape.lo, shape.hi);
}

template <typename Field>
CellState StateOfSweptSphere(const Octree<Field>& map, std::span<const Vec3> path, double radius_m) {
  assert(!path.empty());
  CellState state = CellState::kFree;
  const Vec3 margin = Vec3::Constant(radius_m + map.resolution_m());
  for (size_t i = 0; i < path.size(); ++i) {
    const Vec3 &a = path[i], &b = path[i + 1 < path.size() ? i + 1 : i];
    if (i > 0 && i + 1 == path.size()) break;
    const CapsuleShape shape{a / map.resolution_m(), b / map.resolution_m(), radius_m / map.resolution_m()};
    const CellState part =
        StateOf(map, shape, map.KeyAt(a.cwiseMin(b) - margin), map.KeyAt(a.cwiseMax(b) + margin));
    if (part == CellState::kOccupied) return part;
    if (part == CellState::kUnknown) state = part;
  }
  return state;
}

#define ATLAS_INSTANTIATE(Field)                                                                      \
  template std::optional<double> FirstOccupied<Field>(const Octree<Field>&, const Vec3&, const Vec3&, \
                                                      double);                                        \
  template CellState StateOfBox<Field>(const Octree<Field>&, const core::Box3&);                      \
  template CellState StateOfSweptSphere<Field>(const Octree<Field>&, std::span<const Vec3>, double);
ATLAS_INSTANTIATE(OccupancyField)
ATLAS_INSTANTIATE(TsdfField)
#undef ATLAS_INSTANTIATE

}  // namespace atlas::mapping
