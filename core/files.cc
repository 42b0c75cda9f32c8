#include "core/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/errors.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

fs::path InstallRoot() {
  const char* home = std::getenv("ATLAS_HOME");
  return home != nullptr && *home != '\0' ? fs::path(home) : fs::path(ATLAS_SOURCE_DIR);
}

}  // namespace

void WriteFileAtomically(const fs::path& path, std::string_view content) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  const fs::path beside = path.string() + fmt::format(".tmp{}", ::getpid());
  {
    std::ofstream out(beside, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.flush();
    if (!out) {
      const std::string reason = std::strerror(errno);
      fs::remove(beside, error);
      throw InputError(fmt::format("{}: cannot write ({})", path.string(), reason));
    }
  }
  fs::rename(beside, path, error);
  if (error) {
    const std::string reason = error.message();
    fs::remove(beside, error);
    throw InputError(fmt::format("{}: cannot write ({})", path.string(), reason));
  }
}

std::string ReadFile(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(fmt::format("{}: no such file", path.string()));
  if (fs::is_directory(path, error))
    throw InputError(fmt::format("{}: is a folder, not a file", path.string()));
  std::ifstream in(path, std::ios::binary);
  std::ostringstream buffer;
  buffer << in.rdbuf();
  if (!in) throw InputError(fmt::format("{}: cannot read", path.string()));
  return std::move(buffer).str();
}

fs::path InstalledFile(const fs::path& relative) {
  const fs::path path = InstallRoot() / relative;
  std::error_code error;
  if (!fs::exists(path, error))
    throw InputError(fmt::format("{}: no such file in the installation", path.string()));
  return path;
}

fs::path CacheDirectory() {
  const char* cache = std::getenv("ATLAS_CACHE");
  return cache != nullptr && *cache != '\0' ? fs::path(cache) : InstallRoot() / ".cache";
}

}  // namespace atlas::core
