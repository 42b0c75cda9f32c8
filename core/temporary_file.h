// A file under another name beside its target, which takes the target's place when it is whole.
#pragma once

#include <filesystem>

namespace atlas::core {

/// Named TARGET.tmpPID-RANDOM. It is created by this process alone (O_EXCL, no link is followed) and locked
/// while it is written, which tells it from what a dead process left behind.
class TemporaryFile {
 public:
  /// Creates parent folders. @throws InputError naming the target when nothing can be written there; so does
  /// Commit.
  explicit TemporaryFile(std::filesystem::path target);
  /// Removes what was not committed.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Open for reading and writing; not inherited by other programs.
  int descriptor() const { return file_; }
  /// Syncs the file to the disk, renames it over the target, and syncs the folder.
  void Commit();
  /// @throws InputError "TARGET: cannot write (what `error`, of errno, means)".
  [[noreturn]] void Fail(int error) const;

 private:
  std::filesystem::path target_, path_;
  int file_ = -1;
  bool committed_ = false;
};

/// Removes the temporary files in `folder` (empty: the working folder) that no process writes any more, since
/// nobody holds their lock. Anything else is left alone, and so is what cannot be removed. Returns how many
/// went.
size_t RemoveStaleTemporaries(const std::filesystem::path& folder);

}  // namespace atlas::core
