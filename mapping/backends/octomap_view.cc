#include "mapping/backends/octomap_view.h"

#include <bit>

#include "mapping/octree/voxel_ray.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using octomap::OcTreeKey;
using octomap::OcTreeNode;

constexpr unsigned kTreeDepth = 16;

/// Finds leaves of voxels that lie near each other, as along a ray: a search goes up only to the node that
/// holds the last voxel and the next one.
class LeafCursor {
 public:
  explicit LeafCursor(const octomap::OcTree& tree) : tree_(tree) { path_[0] = tree.getRoot(); }

  /// The leaf that holds the voxel, null where there is none.
  const OcTreeNode* At(const OcTreeKey& key) {
    if (path_[0] == nullptr) {
      height_ = kTreeDepth;
      return nullptr;
    }
    const unsigned differing = (key[0] ^ key_[0]) | (key[1] ^ key_[1]) | (key[2] ^ key_[2]);
    if (started_ && differing >> height_ == 0) return leaf_;
    Descend(key, started_ ? static_cast<unsigned>(std::bit_width(differing)) : kTreeDepth);
    key_ = key;
    started_ = true;
    return leaf_;
  }

  /// The last answer holds for the aligned cube of 2^height voxels a side.
  int height() const { return static_cast<int>(height_); }

 private:
  /// From the node of this height above the voxels that holds the key, down to the key's leaf or to the
  /// child that is missing.
  void Descend(const OcTreeKey& key, unsigned height) {
    unsigned depth = kTreeDepth - height;
    leaf_ = path_[depth];
    height_ = height;
    while (height_ > 0 && tree_.nodeHasChildren(leaf_)) {
      --height_;
      const unsigned child =
          (key[0] >> height_ & 1) | (key[1] >> height_ & 1) << 1 | (key[2] >> height_ & 1) << 2;
      if (!tree_.nodeChildExists(leaf_, child)) {
        leaf_ = nullptr;
        return;
      }
      leaf_ = tree_.getNodeChild(leaf_, child);
      path_[++depth] = leaf_;
    }
  }

  const octomap::OcTree& tree_;
  const OcTreeNode* path_[kTreeDepth + 1] = {};  ///< from the root to the leaf, or to its last ancestor
  const OcTreeNode* leaf_ = nullptr;
  unsigned height_ = kTreeDepth;  ///< the answer holds for all voxels that agree above these low bits
  OcTreeKey key_{0, 0, 0};
  bool started_ = false;
};

/// Probabilities of log-odds, which repeat from voxel to voxel.
class Probability {
 public:
  float Of(float log_odds) {
    if (log_odds != log_odds_) {
      log_odds_ = log_odds;
      p_ = static_cast<float>(octomap::probability(static_cast<double>(log_odds)));
    }
    return p_;
  }

 private:
  float log_odds_ = 0.0f, p_ = 0.5f;
};

OcTreeKey KeyOf(const NodeKey& voxel) {
  return {static_cast<uint16_t>(voxel.x + kOctomapZero), static_cast<uint16_t>(voxel.y + kOctomapZero),
          static_cast<uint16_t>(voxel.z + kOctomapZero)};
}

}  // namespace

CellState OctomapView::StateAt(const Vec3& p_map) const {
  const OcTreeNode* node = contents_->tree.search(p_map.x(), p_map.y(), p_map.z());
  return node == nullptr ? CellState::kUnknown : StateOf(static_cast<float>(node->getOccupancy()));
}

RayEnd OctomapView::Trace(const Vec3& origin_map, const Vec3& direction_map, const TraceLimits& limits,
                          std::vector<RaySample>* samples) const {
  RaySamples met(limits, samples);
  const auto span = limits.box_map.Clip(origin_map, direction_map);
  if (!span || span->first >= limits.max_range_m) return RayEnd::kVoid;
  VoxelRay ray(origin_map, direction_map, resolution_m(), span->first,
               std::min(span->second, limits.max_range_m), VoxelsOf(limits.box_map, resolution_m()));
  const BehindSurface* const behind =
      limits.behind_surface && contents_->behind ? &*contents_->behind : nullptr;
  LeafCursor leaves(contents_->tree);
  Probability probability;

  bool occupied = false, on = true;
  while (on) {
    const NodeKey voxel = ray.voxel();
    const BehindSurface::Block* const marks = behind != nullptr ? behind->Find(voxel) : nullptr;
    const OcTreeNode* const first = leaves.At(KeyOf(voxel));
    const float p_first = first != nullptr ? probability.Of(first->getLogOdds()) : 0.5f;
    const CellState state_first = first != nullptr ? StateOf(p_first) : CellState::kUnknown;
    const bool joins = first == nullptr ? !limits.each_unmeasured : state_first == CellState::kFree;
    if (joins && marks == nullptr && leaves.height() >= kBlockLevel) {
      uint32_t voxels = 0;
      float length_m = 0.0f;
      on = ray.CrossCube(behind != nullptr ? kBlockLevel : leaves.height(), &voxels, &length_m);
      met.Add({.occupancy = p_first,
               .length_m = length_m,
               .key = PackedKey(voxel),
               .voxels = voxels,
               .state = state_first});
      continue;
    }
    on = ray.CrossVoxels(&occupied, [&](int index, double length_m) {
      const NodeKey at = ray.voxel();
      const OcTreeNode* const leaf = leaves.At(KeyOf(at));
      if (leaf == nullptr) {
        const float mark = marks != nullptr ? static_cast<float>((*marks)[static_cast<size_t>(index)]) : 0.0f;
        return met.Add({.length_m = static_cast<float>(length_m),
                        .key = PackedKey(at),
                        .behind_surface = mark,
                        .state = CellState::kUnknown});
      }
      const float p = probability.Of(leaf->getLogOdds());
      return met.Add({.occupancy = p, .length_m = static_cast<float>(length_m), .key = PackedKey(at)});
    });
  }
  return occupied ? RayEnd::kOccupied : RayEnd::kVoid;
}

void OctomapView::ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const {
  const octomap::OcTree& tree = contents_->tree;
  const double voxel_m = resolution_m();
  for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
    if (StateOf(static_cast<float>(leaf->getOccupancy())) != CellState::kOccupied) continue;
    // A pruned leaf stands for a cube of voxels.
    const int side = 1 << (kTreeDepth - leaf.getDepth());
    const Vec3 low = Vec3(leaf.getX(), leaf.getY(), leaf.getZ()).array() - 0.5 * (side - 1) * voxel_m;
    for (int i = 0; i < side * side * side; ++i) {
      const Vec3 p = low + voxel_m * Vec3(i % side, i / side % side, i / side / side);
      if (box_map.Contains(p)) visit(p.cast<float>());
    }
  }
}

}  // namespace atlas::mapping
