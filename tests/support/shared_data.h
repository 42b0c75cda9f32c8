// Real data sets that the project does not carry.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

#include "tests/support/source_tree.h"

namespace atlas::tests {

/// `relative` below $ATLAS_SHARED_DATA or ../shared/data beside the repository, where it is there.
inline std::optional<std::filesystem::path> SharedData(const std::filesystem::path& relative) {
  const char* given = std::getenv("ATLAS_SHARED_DATA");
  const std::filesystem::path root =
      given != nullptr ? std::filesystem::path(given) : SourceTree().parent_path() / "shared" / "data";
  std::error_code error;
  if (!std::filesystem::exists(root / relative, error)) return std::nullopt;
  return root / relative;
}

}  // namespace atlas::tests
