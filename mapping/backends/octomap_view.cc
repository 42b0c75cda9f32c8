#include "mapping/backends/octomap_view.h"

#include <octomap/OcTree.h>

#include <bit>

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;
using octomap::OcTreeKey;
using octomap::OcTreeNode;

constexpr unsigned kTreeDepth = 16;
constexpr int kGreatestBehind = 31;

/// Finds leaves of voxels that lie near each other, as along a ray: a search goes up only to the node that
/// holds the last voxel and the next one.
class LeafCursor {
 public:
  explicit LeafCursor(const octomap::OcTree& tree) : tree_(tree) { path_[0] = tree.getRoot(); }

  /// The leaf that holds the voxel, null where there is none.
  const OcTreeNode* At(const OcTreeKey& key) {
    if (path_[0] == nullptr) return nullptr;
    const unsigned differing = (key[0] ^ key_[0]) | (key[1] ^ key_[1]) | (key[2] ^ key_[2]);
    if (started_ && differing >> height_ == 0) return leaf_;
    Descend(key, started_ ? static_cast<unsigned>(std::bit_width(differing)) : kTreeDepth);
    key_ = key;
    started_ = true;
    return leaf_;
  }

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

}  // namespace

OctomapView::OctomapView(const octomap::OcTree& tree, const GridFrame& frame)
    : tree_(tree), frame_(frame), behind_(frame.count(), 0), occupied_(frame.box()) {
  const Vec3 first = frame.CenterOf(0);
  for (unsigned a = 0; a < 3; ++a) first_key_[a] = tree.coordToKey(first[static_cast<int>(a)]);
}

bool OctomapView::Holds(const OcTreeKey& key) const {
  for (unsigned a = 0; a < 3; ++a) {
    const int cell = static_cast<int>(key[a]) - static_cast<int>(first_key_[a]);
    if (cell < 0 || cell >= frame_.size()[a]) return false;
  }
  return true;
}

void OctomapView::SetBehindSurface(size_t index, int value) {
  behind_[index] = static_cast<uint8_t>(std::max<int>(behind_[index], std::min(value, kGreatestBehind)));
}

void OctomapView::FinishUpdate() {
  std::vector<Vec3f> centers;
  const double voxel_m = frame_.resolution_m();
  for (auto leaf = tree_.begin_leafs(), end = tree_.end_leafs(); leaf != end; ++leaf) {
    if (StateOf(static_cast<float>(leaf->getOccupancy())) != CellState::kOccupied) continue;
    // A pruned leaf stands for a cube of voxels.
    const int side = 1 << (kTreeDepth - leaf.getDepth());
    const Vec3 low = Vec3(leaf.getX(), leaf.getY(), leaf.getZ()).array() - 0.5 * (side - 1) * voxel_m;
    for (int i = 0; i < side * side * side; ++i) {
      const Vec3 p = low + voxel_m * Vec3(i % side, i / side % side, i / side / side);
      if (frame_.IndexAt(p) >= 0) centers.push_back(p.cast<float>());
    }
  }
  occupied_.Build(std::move(centers));
}

CellState OctomapView::StateAt(const Vec3& p_map) const {
  if (frame_.IndexAt(p_map) < 0) return CellState::kUnknown;
  const OcTreeNode* node = tree_.search(p_map.x(), p_map.y(), p_map.z());
  return node == nullptr ? CellState::kUnknown : StateOf(static_cast<float>(node->getOccupancy()));
}

RayEnd OctomapView::Trace(const Vec3& origin_map, const Vec3& direction_map, double max_range_m,
                          std::vector<RaySample>* samples) const {
  samples->clear();
  LeafCursor leaves(tree_);
  Probability probability;
  const bool occupied = frame_.WalkCells(
      origin_map, direction_map, max_range_m,
      [&](const int cell[3], size_t index, double t_enter, double t_leave) {
        const OcTreeKey key(static_cast<uint16_t>(first_key_[0] + cell[0]),
                            static_cast<uint16_t>(first_key_[1] + cell[1]),
                            static_cast<uint16_t>(first_key_[2] + cell[2]));
        const auto length_m = static_cast<float>(t_leave - t_enter);
        const OcTreeNode* leaf = leaves.At(key);
        if (leaf == nullptr) {
          samples->push_back({0.5f, length_m, index, static_cast<float>(behind_[index])});
          return true;
        }
        const float p = probability.Of(leaf->getLogOdds());
        const CellState state = StateOf(p);
        if (state == CellState::kFree && !samples->empty() && samples->back().occupancy == p) {
          samples->back().length_m += length_m;
          ++samples->back().voxels;
          return true;
        }
        samples->push_back({p, length_m, index, 0.0f, 1, state});
        return state != CellState::kOccupied;
      });
  return occupied ? RayEnd::kOccupied : RayEnd::kVoid;
}

}  // namespace atlas::mapping
