// Where the sources lie. Found at run time: a path compiled in would differ between checkouts, and with it
// every object that the compiler cache could share.
#pragma once

#include <filesystem>

#include "core/files.h"

namespace atlas::tests {

/// The repository's root: $ATLAS_HOME where set.
inline std::filesystem::path SourceTree() {
  return core::InstalledFile("CMakeLists.txt").parent_path();
}

/// The program under test, built beside the test executables.
inline std::filesystem::path AtlasBinary() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "atlas";
}

}  // namespace atlas::tests
