#include "core/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
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

AtomicFile::AtomicFile(fs::path path)
    : path_(std::move(path)), beside_(path_.string() + fmt::format(".tmp{}", ::getpid())) {
  std::error_code error;
  if (path_.has_parent_path()) fs::create_directories(path_.parent_path(), error);
  out_.open(beside_, std::ios::binary | std::ios::trunc);
  if (!out_) Fail(std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  std::error_code error;
  out_.close();
  fs::remove(beside_, error);
}

void AtomicFile::Fail(const std::string& reason) {
  throw InputError(fmt::format("{}: cannot write ({})", path_.string(), reason));
}

void AtomicFile::Write(std::string_view content) {
  out_.write(content.data(), static_cast<std::streamsize>(content.size()));
  if (!out_) Fail(std::strerror(errno));
}

void AtomicFile::Commit() {
  out_.close();
  if (!out_) Fail(std::strerror(errno));
  std::error_code error;
  fs::rename(beside_, path_, error);
  if (error) Fail(error.message());
  committed_ = true;
}

void WriteFileAtomically(const fs::path& path, std::string_view content) {
  AtomicFile file(path);
  file.Write(content);
  file.Commit();
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
