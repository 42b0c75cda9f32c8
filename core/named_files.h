// Files that other files name: where they lie, and copies of them beside each other.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace atlas::core {

/// Whether a value that may be a name or a file is a file: it has a folder, or ends in .yaml, .yml or .xml.
bool IsFileName(const std::string& value);

/// What a value that stands in a file of `folder` names: a file relative to that folder, else the name
/// itself.
std::string FileBeside(const std::filesystem::path& folder, const std::string& value);

/// Names for copies of `files` in one folder: their own, below a numbered folder where two are the same
/// ("a.obj", "2/a.obj"), for names may carry meaning. A file that is listed twice has one copy.
std::vector<std::filesystem::path> CopyNames(const std::vector<std::filesystem::path>& files);

/// Copies `from` to `to` whole or not at all, creating folders. @throws InputError.
void CopyFile(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace atlas::core
