// Files are written whole or not at all: beside the target, then renamed over it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/temporary_file.h"

namespace atlas::core {

/// Writes `content` to `path`, creating parent folders. @throws InputError naming the path when that fails; a
/// file that was there before is then untouched.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view content);

/// The same for content that is too large to hold at once: written beside the target, renamed over it by
/// Commit. What was not committed leaves nothing behind.
class AtomicFile {
 public:
  /// @throws InputError naming the path when it cannot be written (a full disk, a limit on file sizes); so
  /// does Write, and Commit.
  explicit AtomicFile(std::filesystem::path path) : file_(std::move(path)) {}
  void Write(std::string_view content);
  void Commit();

 private:
  void Send(std::string_view bytes);
  TemporaryFile file_;
  std::string pending_;  ///< small pieces are sent together
};

/// @throws InputError where nothing can be read to its end from here: "PATH: no such file", a folder, a
/// device, a pipe.
void CheckReadable(const std::filesystem::path& path);

/// The whole file. @throws InputError as CheckReadable does, where it is larger than `most_bytes`, and where
/// reading fails.
std::string ReadFile(const std::filesystem::path& path, uintmax_t most_bytes = UINTMAX_MAX);

/// A file of the installation, such as "robots/quadruped.xml": below $ATLAS_HOME where set, else below the
/// source tree. @throws InputError when it is missing.
std::filesystem::path InstalledFile(const std::filesystem::path& relative);

/// Where results that are costly to recompute are kept (attainable coverage): $ATLAS_CACHE, else `.cache`
/// below the installation. Safe to delete.
std::filesystem::path CacheDirectory();

}  // namespace atlas::core
