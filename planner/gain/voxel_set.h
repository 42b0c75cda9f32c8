// Which views have met which voxels: a table of keys that empties at no cost.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atlas::planner {

/// Open-addressing hash table from voxel key to the set of views (a bit each) that have met the voxel.
/// Clear() keeps the storage.
class VoxelViews {
 public:
  VoxelViews() : slot_(size_t{1} << 12) {}

  void Clear() {
    size_ = 0;
    if (++round_ == 0) {
      for (Slot& slot : slot_) slot.round = 0;
      round_ = 1;
    }
  }

  void Add(uint64_t key, uint64_t views) {
    Slot& slot = Find(key);
    if (slot.round == round_) {
      slot.views |= views;
      return;
    }
    slot = {key, views, round_};
    if (2 * ++size_ > slot_.size()) Grow();
  }

  /// How many voxels each of the first `count` views has met.
  std::vector<size_t> Count(size_t count) const {
    std::vector<size_t> voxels(count, 0);
    for (const Slot& slot : slot_) {
      if (slot.round != round_) continue;
      for (uint64_t rest = slot.views; rest != 0; rest &= rest - 1) {
        const auto view = static_cast<size_t>(std::countr_zero(rest));
        if (view < count) ++voxels[view];
      }
    }
    return voxels;
  }

 private:
  struct Slot {
    uint64_t key = 0, views = 0;
    uint32_t round = 0;
  };

  Slot& Find(uint64_t key) {
    const size_t mask = slot_.size() - 1;
    size_t i = static_cast<size_t>((key * 0x9e3779b97f4a7c15ULL) >> 20) & mask;
    while (slot_[i].round == round_ && slot_[i].key != key) i = (i + 1) & mask;
    return slot_[i];
  }

  void Grow() {
    std::vector<Slot> old(slot_.size() * 2);
    old.swap(slot_);
    for (const Slot& slot : old) {
      if (slot.round == round_) Find(slot.key) = slot;
    }
  }

  std::vector<Slot> slot_;
  uint32_t round_ = 1;
  size_t size_ = 0;
};

}  // namespace atlas::planner
