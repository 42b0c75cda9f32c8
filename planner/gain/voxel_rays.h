// How many sensor rays of each view meet each voxel: a table of keys that empties at no cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atlas::planner {

/// Open-addressing hash table from voxel key to a sum of ray weights for each view. Clear() keeps the
/// storage.
class VoxelRays {
 public:
  VoxelRays() : slot_(size_t{1} << 12) {}

  void Clear(size_t views) {
    views_ = views;
    size_ = 0;
    if (++round_ == 0) {
      for (Slot& slot : slot_) slot.round = 0;
      round_ = 1;
    }
  }

  /// @pre weights has an entry a view.
  void Add(uint64_t key, std::span<const double> weights) {
    Slot& slot = Find(key);
    if (slot.round != round_) {
      slot = {key, static_cast<uint32_t>(size_), round_};
      const size_t needed = ++size_ * views_;
      if (rays_.size() < needed) rays_.resize(2 * needed);
      float* rays = &rays_[needed - views_];
      for (size_t v = 0; v < views_; ++v) rays[v] = static_cast<float>(weights[v]);
      if (2 * size_ > slot_.size()) Grow();
      return;
    }
    float* rays = &rays_[slot.index * views_];
    for (size_t v = 0; v < views_; ++v) rays[v] += static_cast<float>(weights[v]);
  }

  size_t views() const { return views_; }
  size_t size() const { return size_; }
  /// Rays of each view through the i-th voxel met, in order of first meeting.
  std::span<const float> Rays(size_t i) const { return {&rays_[i * views_], views_}; }

 private:
  struct Slot {
    uint64_t key = 0;
    uint32_t index = 0, round = 0;
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
  std::vector<float> rays_;  ///< views_ a voxel
  size_t views_ = 1, size_ = 0;
  uint32_t round_ = 1;
};

}  // namespace atlas::planner
