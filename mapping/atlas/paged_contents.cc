#include "mapping/atlas/paged_contents.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/byte_reader.h"
#include "core/errors.h"
#include "mapping/atlas/distance_states.h"
#include "mapping/io/map_codec.h"

namespace atlas::mapping {
namespace {

[[noreturn]] void FailPaging(const std::string& what, int error) {
  throw core::InputError(fmt::format("mapper.memory_limit_mb: {}: cannot {} ({})",
                                     std::filesystem::temp_directory_path().string(), what,
                                     std::strerror(error)));
}

/// A file without a name in the temporary folder.
int UnnamedFile() {
  std::string path = (std::filesystem::temp_directory_path() / "atlas_pages_XXXXXX").string();
  const int file = mkostemp(path.data(), O_CLOEXEC);
  if (file < 0) FailPaging("make a file", errno);
  unlink(path.c_str());
  return file;
}

void WriteAll(int file, const std::string& bytes) {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n = pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) FailPaging("write", n < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(n);
  }
}

std::string ReadAll(int file) {
  const off_t size = lseek(file, 0, SEEK_END);
  if (size < 0) FailPaging("read", errno);
  std::string bytes(static_cast<size_t>(size), '\0');
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n = pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) FailPaging("read", n < 0 ? errno : EIO);
    done += static_cast<size_t>(n);
  }
  return bytes;
}

template <typename T>
void AppendNumber(T value, std::string* out) {
  out->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// How many chunks hold anything, and these.
template <typename Field>
void AppendTree(const Octree<Field>& tree, std::string* page) {
  std::string chunks;
  uint64_t count = 0;
  for (const typename Octree<Field>::Chunk* chunk : tree.Chunks()) {
    if (!ContentOf(tree, *chunk).any()) continue;
    AppendChunk(tree, *chunk, &chunks);
    ++count;
  }
  AppendNumber(count, page);
  *page += chunks;
}

template <typename Field>
void ReadTree(core::ByteReader* reader, Octree<Field>* tree) {
  const auto count = reader->Next<uint64_t>();
  uint64_t first_code = 0;
  for (uint64_t i = 0; i < count; ++i) ReadChunk(reader, &first_code, tree);
  tree->TakeChanges();
}

/// Resolution, the tree, or the distances that tell it; marks behind surfaces, where they are kept.
std::string ToPage(const OctreeContents& contents) {
  std::string page;
  AppendNumber(contents.tree.resolution_m(), &page);
  AppendNumber(static_cast<uint8_t>(contents.distances.has_value()), &page);
  AppendNumber(static_cast<uint8_t>(contents.behind.has_value()), &page);
  if (contents.distances) {
    AppendTree(*contents.distances, &page);
  } else {
    AppendTree(contents.tree, &page);
  }
  if (contents.behind) contents.behind->AppendTo(&page);
  return page;
}

OctreeContents FromPage(const std::string& page) {
  core::ByteReader reader(page, "a page of the atlas");
  OctreeContents contents{OccupancyOctree(reader.Next<double>()), {}};
  const bool distances = reader.Next<uint8_t>() != 0, behind = reader.Next<uint8_t>() != 0;
  if (distances) {
    contents.distances.emplace(contents.tree.resolution_m());
    ReadTree(&reader, &*contents.distances);
    contents.tree = StatesOf(*contents.distances);
  } else {
    ReadTree(&reader, &contents.tree);
  }
  if (behind) contents.behind = BehindSurface::Read(&reader);
  return contents;
}

size_t BytesOf(const OctreeContents& contents) {
  return contents.tree.Bytes() + (contents.behind ? contents.behind->Bytes() : 0) +
         (contents.distances ? contents.distances->Bytes() : 0);
}

}  // namespace

ContentsPager::Counts ContentsPager::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void ContentsPager::Trim() {
  const std::lock_guard lock(mutex_);
  MakeRoom(nullptr);
}

void ContentsPager::MakeRoom(const StoredContents* keep) {
  while (limit_bytes_ > 0 && counts_.resident_bytes > limit_bytes_) {
    const StoredContents* oldest = nullptr;
    for (const StoredContents* stored : all_) {
      const bool may_go =
          stored != keep && stored->resident_ && !stored->pinned_ && stored->resident_.use_count() == 1;
      if (may_go && (oldest == nullptr || stored->used_ < oldest->used_)) oldest = stored;
    }
    if (oldest == nullptr) return;
    oldest->Unload();
  }
}

StoredContents::StoredContents(std::shared_ptr<ContentsPager> pager, OctreeContents contents)
    : pager_(std::move(pager)),
      resident_(std::make_shared<OctreeContents>(std::move(contents))),
      bytes_(BytesOf(*resident_)) {
  const std::lock_guard lock(pager_->mutex_);
  pager_->all_.insert(this);
  pager_->counts_.resident_bytes += bytes_;
  used_ = ++pager_->clock_;
}

StoredContents::~StoredContents() {
  const std::lock_guard lock(pager_->mutex_);
  pager_->all_.erase(this);
  if (resident_) pager_->counts_.resident_bytes -= bytes_;
  if (file_ >= 0) close(file_);
}

void StoredContents::Load() const {
  resident_ = std::make_shared<OctreeContents>(FromPage(ReadAll(file_)));
  pager_->counts_.resident_bytes += bytes_;
  ++pager_->counts_.read;
}

void StoredContents::Unload() const {
  if (file_ < 0) {
    const int file = UnnamedFile();
    try {
      WriteAll(file, ToPage(*resident_));
    } catch (...) {
      close(file);
      throw;
    }
    file_ = file;
    ++pager_->counts_.written;
  }
  resident_.reset();
  pager_->counts_.resident_bytes -= bytes_;
}

std::shared_ptr<const OctreeContents> StoredContents::Get() const {
  const std::lock_guard lock(pager_->mutex_);
  used_ = ++pager_->clock_;
  if (!resident_) {
    Load();
    pager_->MakeRoom(this);
  }
  return resident_;
}

PagedContents::PagedContents(std::shared_ptr<ContentsPager> pager, OctreeContents contents)
    : pager_(std::move(pager)), held_(std::make_shared<StoredContents>(pager_, std::move(contents))) {}

std::shared_ptr<const StoredContents> PagedContents::Share() const {
  held_->readers_.fetch_add(1, std::memory_order_relaxed);
  return {held_.get(),
          [held = held_](const StoredContents*) { held->readers_.fetch_sub(1, std::memory_order_release); }};
}

size_t PagedContents::ResidentBytes() const {
  const std::lock_guard lock(pager_->mutex_);
  return held_->resident_ ? held_->bytes_ : 0;
}

PagedContents::Writing PagedContents::Write() {
  // Acquired, so that the reads of whoever let go last are over.
  if (held_->readers_.load(std::memory_order_acquire) > 0)
    held_ = std::make_shared<StoredContents>(pager_, held_->Get()->Clone());
  return Writing(held_);
}

PagedContents::Writing::Writing(const std::shared_ptr<StoredContents>& held) : held_(held) {
  const std::lock_guard lock(held_->pager_->mutex_);
  if (!held_->resident_) held_->Load();
  contents_ = held_->resident_;
  held_->pinned_ = true;
  if (held_->file_ >= 0) close(held_->file_);
  held_->file_ = -1;
}

PagedContents::Writing::~Writing() {
  const size_t bytes = BytesOf(*contents_);
  contents_.reset();
  const std::lock_guard lock(held_->pager_->mutex_);
  ContentsPager& pager = *held_->pager_;
  pager.counts_.resident_bytes += bytes - held_->bytes_;
  held_->bytes_ = bytes;
  held_->pinned_ = false;
  held_->used_ = ++pager.clock_;
}

}  // namespace atlas::mapping
