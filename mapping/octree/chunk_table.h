// Chunks by their key: a hash table in one piece, since rays ask it at every chunk that they enter.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "mapping/octree/morton.h"

namespace atlas::mapping {

/// Open addressing with linear probing, at most half full; an erased entry is filled from behind. Copies
/// nothing that it points at. Order of iteration is unspecified.
template <typename Chunk>
class ChunkTable {
 public:
  /// Null where there is none.
  Chunk* Find(const NodeKey& key) const {
    if (slots_.empty()) return nullptr;
    for (size_t i = Home(key);; i = (i + 1) & mask_) {
      const Slot& slot = slots_[i];
      if (slot.chunk == nullptr || slot.key == key) return slot.chunk;
    }
  }

  /// @pre it is not there yet, and `chunk` is not null.
  void Insert(const NodeKey& key, Chunk* chunk) {
    if (2 * (size_ + 1) > slots_.size()) Grow();
    Place({key, chunk});
    ++size_;
  }

  /// @pre it is there.
  void Erase(const NodeKey& key) {
    size_t hole = Home(key);
    while (!(slots_[hole].key == key)) hole = (hole + 1) & mask_;
    // What was pushed past the hole by a collision moves back into it.
    for (size_t i = (hole + 1) & mask_; slots_[i].chunk != nullptr; i = (i + 1) & mask_) {
      const size_t home = Home(slots_[i].key);
      if (((i - home) & mask_) < ((i - hole) & mask_)) continue;
      slots_[hole] = slots_[i];
      hole = i;
    }
    slots_[hole] = {};
    if (--size_ == 0) slots_ = {};
  }

  size_t size() const { return size_; }
  size_t Bytes() const { return slots_.size() * sizeof(Slot); }

  template <typename Visit>
  void ForEach(const Visit& visit) const {
    for (const Slot& slot : slots_) {
      if (slot.chunk != nullptr) visit(slot.chunk);
    }
  }

 private:
  struct Slot {
    NodeKey key;
    Chunk* chunk = nullptr;
  };

  size_t Home(const NodeKey& key) const {
    const uint64_t mixed = static_cast<uint32_t>(key.x) * 0x9e3779b97f4a7c15u ^
                           static_cast<uint32_t>(key.y) * 0xc2b2ae3d27d4eb4fu ^
                           static_cast<uint32_t>(key.z) * 0x165667b19e3779f9u;
    return (mixed ^ mixed >> 32) & mask_;
  }
  void Place(const Slot& slot) {
    size_t i = Home(slot.key);
    while (slots_[i].chunk != nullptr) i = (i + 1) & mask_;
    slots_[i] = slot;
  }
  void Grow() {
    const std::vector<Slot> before =
        std::exchange(slots_, std::vector<Slot>(slots_.empty() ? 16 : 2 * slots_.size()));
    mask_ = slots_.size() - 1;
    for (const Slot& slot : before) {
      if (slot.chunk != nullptr) Place(slot);
    }
  }

  std::vector<Slot> slots_;
  size_t mask_ = 0, size_ = 0;
};

}  // namespace atlas::mapping
