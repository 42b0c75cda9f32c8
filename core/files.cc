#include "core/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/errors.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

constexpr size_t kPieceBytes = 1 << 16;

fs::path InstallRoot() {
  const char* home = std::getenv("ATLAS_HOME");
  return home != nullptr && *home != '\0' ? fs::path(home) : fs::path(ATLAS_SOURCE_DIR);
}

}  // namespace

void AtomicFile::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::write(file_.descriptor(), bytes.data(), bytes.size());
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) file_.Fail(sent == 0 ? ENOSPC : errno);
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
}

void AtomicFile::Write(std::string_view content) {
  if (pending_.size() + content.size() > kPieceBytes) {
    Send(pending_);
    pending_.clear();
  }
  if (content.size() > kPieceBytes) {
    Send(content);
  } else {
    pending_ += content;
  }
}

void AtomicFile::Commit() {
  Send(pending_);
  pending_.clear();
  file_.Commit();
}

void WriteFileAtomically(const fs::path& path, std::string_view content) {
  AtomicFile file(path);
  file.Write(content);
  file.Commit();
}

void CheckReadable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(fmt::format("{}: no such file", path.string()));
  if (fs::is_directory(status)) throw InputError(fmt::format("{}: is a folder, not a file", path.string()));
  if (!fs::is_regular_file(status))
    throw InputError(fmt::format("{}: is a device or a pipe, not a file", path.string()));
}

std::string ReadFile(const fs::path& path, uintmax_t most_bytes) {
  CheckReadable(path);
  std::error_code error;
  if (const uintmax_t bytes = fs::file_size(path, error); !error && bytes > most_bytes)
    throw InputError(fmt::format("{}: {} bytes, must be at most {}", path.string(), bytes, most_bytes));
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
