#include "core/named_files.h"

#include <algorithm>
#include <set>

#include "core/files.h"

namespace atlas::core {
namespace fs = std::filesystem;

bool IsFileName(const std::string& value) {
  const std::string extension = fs::path(value).extension().string();
  return extension == ".yaml" || extension == ".yml" || extension == ".xml" ||
         value.find('/') != std::string::npos;
}

std::string FileBeside(const fs::path& folder, const std::string& value) {
  if (folder.empty() || !IsFileName(value) || fs::path(value).is_absolute()) return value;
  return (folder / value).lexically_normal().string();
}

std::vector<fs::path> CopyNames(const std::vector<fs::path>& files) {
  std::vector<fs::path> names;
  std::set<fs::path> taken;
  for (size_t i = 0; i < files.size(); ++i) {
    const auto earlier = std::find(files.begin(), files.begin() + static_cast<std::ptrdiff_t>(i), files[i]);
    const auto index = static_cast<size_t>(earlier - files.begin());
    if (index < i) {
      names.push_back(names[index]);
      continue;
    }
    fs::path name = files[i].filename();
    for (int k = 2; !taken.insert(name).second; ++k) name = fs::path(std::to_string(k)) / files[i].filename();
    names.push_back(name);
  }
  return names;
}

void CopyFile(const fs::path& from, const fs::path& to) {
  WriteFileAtomically(to, ReadFile(from));
}

}  // namespace atlas::core
