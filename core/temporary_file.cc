#include "core/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>
#include <string>
#include <string_view>

#include "core/errors.h"
#include "core/text_lines.h"

namespace atlas::core {
namespace fs = std::filesystem;
namespace {

constexpr int kTries = 100;
constexpr size_t kRandomDigits = 16;

fs::path FolderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::string RandomName(const fs::path& target) {
  static_assert(sizeof(std::random_device::result_type) == 4);
  std::random_device random;  // of the kernel: others cannot guess it
  return fmt::format("{}.tmp{}-{:08x}{:08x}", target.string(), getpid(), random(), random());
}

/// Creates a file that nobody else has and locks it, or returns -1 with errno.
int CreateLocked(const fs::path& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file < 0) return -1;
  // Only a sweep of stale files, between the two calls, holds the lock; then another name is tried. File
  // systems without locks do without: there nothing is swept.
  if (flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return file;
  close(file);
  errno = EEXIST;
  return -1;
}

/// Whether a name is of the form "ANYTHING.tmpPID-RANDOM".
bool IsTemporary(std::string_view name) {
  const size_t at = name.rfind(".tmp");
  if (at == std::string_view::npos || at == 0) return false;
  const std::string_view number = name.substr(at + 4);
  const size_t dash = number.find('-');
  if (dash == std::string_view::npos) return false;
  const std::string_view random = number.substr(dash + 1);
  const bool hexadecimal = random.find_first_not_of("0123456789abcdef") == std::string_view::npos;
  return random.size() == kRandomDigits && hexadecimal &&
         ParseNumber<pid_t>(number.substr(0, dash)).has_value();
}

bool RemoveIfUnlocked(const fs::path& path) {
  const int file = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return false;
  struct stat info;
  const bool stale = fstat(file, &info) == 0 && S_ISREG(info.st_mode) && flock(file, LOCK_EX | LOCK_NB) == 0;
  const bool removed = stale && unlink(path.c_str()) == 0;
  close(file);
  return removed;
}

}  // namespace

TemporaryFile::TemporaryFile(fs::path target) : target_(std::move(target)) {
  std::error_code error;
  if (target_.has_parent_path()) fs::create_directories(target_.parent_path(), error);
  for (int i = 0; i < kTries && file_ < 0; ++i) {
    path_ = RandomName(target_);
    file_ = CreateLocked(path_);
    if (file_ < 0 && errno != EEXIST) break;
  }
  if (file_ < 0) Fail(errno);
}

TemporaryFile::~TemporaryFile() {
  if (!committed_) unlink(path_.c_str());
  close(file_);
}

void TemporaryFile::Fail(int error) const {
  throw InputError(fmt::format("{}: cannot write ({})", target_.string(), std::strerror(error)));
}

void TemporaryFile::Commit() {
  if (fsync(file_) != 0) Fail(errno);
  if (rename(path_.c_str(), target_.c_str()) != 0) Fail(errno);
  committed_ = true;
  const int folder = open(FolderOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;  // may be written but not read: the file itself is safe
  const int error = fsync(folder) == 0 || errno == EINVAL ? 0 : errno;
  close(folder);
  if (error != 0) Fail(error);
}

size_t RemoveStaleTemporaries(const fs::path& folder) {
  size_t removed = 0;
  std::error_code error;
  const fs::path there = folder.empty() ? "." : folder;
  for (fs::directory_iterator entry(there, error), end; !error && entry != end; entry.increment(error)) {
    if (IsTemporary(entry->path().filename().string()) && RemoveIfUnlocked(entry->path())) ++removed;
  }
  return removed;
}

}  // namespace atlas::core
