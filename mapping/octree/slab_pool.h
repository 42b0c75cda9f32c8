// Fixed-size cells out of large slabs, by index; a cache a worker, so that threads rarely meet.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

namespace atlas::mapping {

/// Indices stay valid until freed; references too. Workers allocate and free at the same time, each through
/// its own number; a cell is read only by who owns it. Cells come uninitialised.
/// @tparam kSlabBits  2^kSlabBits cells a slab.
template <typename T, uint32_t kSlabBits = 12>
class SlabPool {
 public:
  explicit SlabPool(int workers = 1)
      : slabs_(static_cast<T**>(std::calloc(kMaxSlabs, sizeof(T*)))), caches_(static_cast<size_t>(workers)) {
    if (slabs_ == nullptr) throw std::bad_alloc();
  }
  SlabPool(const SlabPool&) = delete;
  SlabPool& operator=(const SlabPool&) = delete;
  ~SlabPool() {
    for (size_t i = 0; i < taken_; ++i) ::operator delete(slabs_[i], kAlignment);
  }

  /// Room for `workers` callers at a time; never shrinks. Not while others allocate.
  void SetWorkers(int workers) {
    if (static_cast<size_t>(workers) > caches_.size()) caches_.resize(static_cast<size_t>(workers));
  }

  T& operator[](uint32_t index) { return slabs_[index >> kSlabBits][index & kSlabMask]; }
  const T& operator[](uint32_t index) const { return slabs_[index >> kSlabBits][index & kSlabMask]; }

  uint32_t Allocate(int worker) {
    Cache& cache = caches_[static_cast<size_t>(worker)];
    ++cache.in_use;
    if (!cache.free.empty()) {
      const uint32_t index = cache.free.back();
      cache.free.pop_back();
      return index;
    }
    if (cache.next == cache.end) TakeSlab(&cache);
    return cache.next++;
  }
  void Free(uint32_t index, int worker) {
    Cache& cache = caches_[static_cast<size_t>(worker)];
    --cache.in_use;
    cache.free.push_back(index);
  }

  size_t in_use() const {
    int64_t sum = 0;
    for (const Cache& cache : caches_) sum += cache.in_use;
    return static_cast<size_t>(sum);
  }
  /// What was taken from the system, used or not.
  size_t ReservedBytes() const { return taken_ * sizeof(T) << kSlabBits; }

 private:
  static constexpr uint32_t kSlabMask = (1u << kSlabBits) - 1;
  static constexpr size_t kMaxSlabs = size_t{1} << 15;
  static constexpr size_t kHugePage = size_t{1} << 21;
  /// Slabs of whole huge pages ask the system for them: fewer faults while a map grows.
  static constexpr bool kHuge = (sizeof(T) << kSlabBits) % kHugePage == 0;
  static constexpr std::align_val_t kAlignment{kHuge ? kHugePage : alignof(T)};
  struct Release {
    void operator()(T** p) const { std::free(p); }
  };
  struct alignas(64) Cache {
    std::vector<uint32_t> free;
    uint32_t next = 0, end = 0;
    int64_t in_use = 0;  ///< negative where a worker freed what others allocated
  };

  void TakeSlab(Cache* cache) {
    const std::lock_guard lock(mutex_);
    if (taken_ == kMaxSlabs) throw std::bad_alloc();
    slabs_[taken_] = static_cast<T*>(::operator new(sizeof(T) << kSlabBits, kAlignment));
    if constexpr (kHuge) madvise(slabs_[taken_], sizeof(T) << kSlabBits, MADV_HUGEPAGE);
    cache->next = static_cast<uint32_t>(taken_) << kSlabBits;
    cache->end = cache->next + (1u << kSlabBits);
    ++taken_;
  }

  std::unique_ptr<T*[], Release> slabs_;  // never resized: readers need no lock; untouched while unused
  std::vector<Cache> caches_;
  std::mutex mutex_;
  size_t taken_ = 0;
};

}  // namespace atlas::mapping
