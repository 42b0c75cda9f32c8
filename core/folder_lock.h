// One process at a time works in a folder.
#pragma once

#include <filesystem>

namespace atlas::core {

/// Keeps others that ask for it out of a folder while it lives. The lock is the folder's own (flock), so it
/// leaves no file behind, and ends with the process however that ends. File systems that have no locks keep
/// nobody out.
class FolderLock {
 public:
  FolderLock() = default;
  /// @throws InputError "FOLDER: another process works there" where it is held.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace atlas::core
