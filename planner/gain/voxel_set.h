// Which voxels a view has met: a set of keys that empties at no cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atlas::planner {

/// Open-addressing hash set of voxel keys. Clear() keeps the storage.
class VoxelSet {
 public:
  VoxelSet() : slot_(size_t{1} << 12) {}

  void Clear() {
    size_ = 0;
    if (++round_ == 0) {
      for (Slot& slot : slot_) slot.round = 0;
      round_ = 1;
    }
  }

  /// @return whether `key` was not there before.
  bool Insert(uint64_t key) {
    if (2 * (size_ + 1) > slot_.size()) Grow();
    Slot& slot = Find(key);
    if (slot.round == round_) return false;
    slot = {key, round_};
    ++size_;
    return true;
  }

  size_t size() const { return size_; }

 private:
  struct Slot {
    uint64_t key = 0;
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
