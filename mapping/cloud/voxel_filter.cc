#include "mapping/cloud/voxel_filter.h"

#include <cmath>

#include "core/rng.h"

namespace atlas::mapping {

bool VoxelFilter::Insert(const core::Vec3f& p) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(static_cast<double>(p[axis]) * inverse_cell_));
    key = (key << 21) | (static_cast<uint64_t>(cell + (1 << 20)) & 0x1fffff);
  }
  if (2 * (size_ + 1) > table_.size()) Grow();
  const size_t mask = table_.size() - 1;
  for (size_t slot = core::HashCounter(0, key) & mask;; slot = (slot + 1) & mask) {
    if (table_[slot] == key) return false;
    if (table_[slot] == kEmpty) {
      table_[slot] = key;
      ++size_;
      return true;
    }
  }
}

void VoxelFilter::Grow() {
  std::vector<uint64_t> old(2 * table_.size(), kEmpty);
  old.swap(table_);
  const size_t mask = table_.size() - 1;
  for (const uint64_t key : old) {
    if (key == kEmpty) continue;
    size_t slot = core::HashCounter(0, key) & mask;
    while (table_[slot] != kEmpty) slot = (slot + 1) & mask;
    table_[slot] = key;
  }
}

}  // namespace atlas::mapping
