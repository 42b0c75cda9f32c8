// Octrees of submaps: in memory up to a limit, beyond it in files.
//
//     Submap ─PagedContents─> contents, version 3 <── written by the atlas
//     view of earlier ──────> contents, version 2 <── as it was, for as long as a view shares it
//                                 │
//                                 └─ in memory, or in an unnamed file of the system's temporary folder, from
//                                    which it is read back when somebody asks
//
// A view shares a version, not its memory: what it never asks about stays on disk, and what it has asked
// about stays in memory for as long as the view does, so that questions need no lock. The alternative, views
// that hold all submaps in memory, would undo paging with every snapshot. Contents are the same, read back or
// not, and so are all answers, whatever the limit and whichever threads ask.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>

#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

class StoredContents;

/// Keeps the contents that were used last in memory; files vanish with the process, however that ends.
class ContentsPager {
 public:
  /// @param limit_bytes  of octrees in memory that no view and no writer holds on to; 0: no limit
  explicit ContentsPager(size_t limit_bytes) : limit_bytes_(limit_bytes) {}
  ContentsPager(const ContentsPager&) = delete;
  ContentsPager& operator=(const ContentsPager&) = delete;

  struct Counts {
    size_t resident_bytes = 0;       ///< in memory
    uint64_t written = 0, read = 0;  ///< files, so far
  };
  Counts counts() const;
  /// Call after writing. @throws InputError where the temporary folder has no room.
  void Trim();

 private:
  friend class StoredContents;
  friend class PagedContents;
  /// Until the limit holds, or nothing is left that may go. @pre the lock is held.
  void MakeRoom(const StoredContents* keep);

  const size_t limit_bytes_;
  mutable std::mutex mutex_;
  std::set<const StoredContents*> all_;
  uint64_t clock_ = 0;  ///< of uses
  Counts counts_;
};

/// One version of a submap's contents. For any thread.
class StoredContents {
 public:
  StoredContents(std::shared_ptr<ContentsPager> pager, OctreeContents contents);
  ~StoredContents();
  StoredContents(const StoredContents&) = delete;
  StoredContents& operator=(const StoredContents&) = delete;

  /// Stays in memory for as long as it is held. @throws InputError where the temporary folder has no room.
  std::shared_ptr<const OctreeContents> Get() const;

 private:
  friend class ContentsPager;
  friend class PagedContents;
  void Load() const;
  void Unload() const;

  const std::shared_ptr<ContentsPager> pager_;
  // Guarded by the pager's lock; what is resident is written by the owner alone, while pinned.
  mutable std::shared_ptr<OctreeContents> resident_;
  mutable size_t bytes_ = 0;
  mutable uint64_t used_ = 0;
  mutable int file_ = -1;  ///< descriptor; -1: there is none
  mutable bool pinned_ = false;
  mutable std::atomic<int> readers_{0};
};

/// A submap's contents: one owner writes; what it shared before stays as it was, copied only where somebody
/// still holds it.
class PagedContents {
 public:
  PagedContents(std::shared_ptr<ContentsPager> pager, OctreeContents contents);

  std::shared_ptr<const OctreeContents> Read() const { return held_->Get(); }
  std::shared_ptr<const StoredContents> Share() const;
  size_t ResidentBytes() const;

  /// Contents in memory to be written, until it goes out of scope.
  class Writing {
   public:
    explicit Writing(const std::shared_ptr<StoredContents>& held);
    ~Writing();
    Writing(const Writing&) = delete;
    Writing& operator=(const Writing&) = delete;
    OctreeContents& operator*() const { return *contents_; }
    OctreeContents* operator->() const { return contents_.get(); }

   private:
    std::shared_ptr<StoredContents> held_;
    std::shared_ptr<OctreeContents> contents_;
  };
  Writing Write();

 private:
  std::shared_ptr<ContentsPager> pager_;
  std::shared_ptr<StoredContents> held_;
};

}  // namespace atlas::mapping
