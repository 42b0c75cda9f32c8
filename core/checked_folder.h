// Folders of files that belong together: files.csv lists them with their sizes and checksums, and is written
// last, so that what is not whole is found out.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace atlas::core {

/// Whether a file of that name belongs to the kind of folder.
using IsOwnFile = std::function<bool(const std::string& name)>;

/// Remembers what it wrote. @throws InputError where a file cannot be written.
class CheckedFolderWriter {
 public:
  explicit CheckedFolderWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path At(const std::string& name) const { return folder_ / name; }
  void Text(const std::string& name, const std::string& content);
  /// A file that somebody else wrote there.
  void Written(const std::string& name);
  /// Removes files of its own kind that stood there before, and writes the list, which closes with its own
  /// checksum.
  void Finish(const IsOwnFile& is_own) const;

 private:
  std::filesystem::path folder_;
  std::string list_ = "file,bytes,crc64\n";
};

/// @throws InputError (one line) unless every file of the list is there as it was written.
void CheckFolder(const std::filesystem::path& folder, const IsOwnFile& is_own);

}  // namespace atlas::core
