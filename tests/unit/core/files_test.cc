// Files that are whole or absent, whatever the disk, a crash or another user's links do.
#include "core/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/errors.h"

namespace {

/// Names of what was synced, as they were at the time.
std::vector<std::string>& Synced() {
  static std::vector<std::string> names;
  return names;
}

}  // namespace

/// In the C library's place: notes the name and passes the call on.
extern "C" int fsync(int file) {
  std::error_code error;
  Synced().push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file), error).string());
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace atlas::core {
namespace {

namespace fs = std::filesystem;

class FilesTest : public ::testing::Test {
 protected:
  FilesTest() { fs::create_directories(dir_); }
  ~FilesTest() override { fs::remove_all(dir_); }

  size_t Entries() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(dir_), fs::directory_iterator()));
  }
  void Plant(const std::string& name, const std::string& text) const { std::ofstream(dir_ / name) << text; }

  const fs::path dir_ = fs::canonical(fs::temp_directory_path()) /
                        ("atlas_files_" + std::to_string(getpid()) + "_" +
                         ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

/// The limit on file sizes while it lives; exceeding it is an error instead of a signal.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_;
  void (*handler_)(int);
};

TEST_F(FilesTest, AreWrittenWholeOrNotAtAll) {
  WriteFileAtomically(dir_ / "deep" / "a.txt", "one");
  WriteFileAtomically(dir_ / "deep" / "a.txt", "two");
  EXPECT_EQ(ReadFile(dir_ / "deep" / "a.txt"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(dir_ / "deep"), {}), 1);
  EXPECT_THROW(WriteFileAtomically(dir_ / "deep" / "a.txt" / "b", "x"), InputError);
  EXPECT_THROW(ReadFile(dir_ / "none"), InputError);
  EXPECT_THROW(ReadFile(dir_), InputError);
}

TEST_F(FilesTest, PiecesOfAllSizesArriveInOrder) {
  std::string whole;
  {
    AtomicFile file(dir_ / "pieces");
    for (const size_t size : {1u, 70000u, 3u, 65536u, 0u, 65535u, 2u}) {
      const std::string piece(size, static_cast<char>('a' + whole.size() % 26));
      file.Write(piece);
      whole += piece;
    }
    EXPECT_FALSE(fs::exists(dir_ / "pieces"));
    file.Commit();
  }
  EXPECT_EQ(ReadFile(dir_ / "pieces"), whole);
}

TEST_F(FilesTest, WhatDoesNotFitIsAnErrorThatLeavesTheOldFile) {
  WriteFileAtomically(dir_ / "a", "old");
  for (const size_t size : {size_t{50000}, size_t{1} << 20}) {  // within the buffer, and beyond it
    const FileSizeLimit limit(20000);
    try {
      WriteFileAtomically(dir_ / "a", std::string(size, 'x'));
      FAIL() << size;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("/a: cannot write (File too large)"), std::string::npos);
    }
  }
  EXPECT_EQ(ReadFile(dir_ / "a"), "old");
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(FilesTest, LinksPlantedAtTemporaryNamesAreNotFollowed) {
  Plant("victim", "untouched");
  // A name that can be foretold, of the process that will write.
  fs::create_symlink(dir_ / "victim", dir_ / ("a.tmp" + std::to_string(getpid())));
  WriteFileAtomically(dir_ / "a", "new");
  EXPECT_EQ(ReadFile(dir_ / "victim"), "untouched");
  EXPECT_EQ(ReadFile(dir_ / "a"), "new");
  // The target itself: the link gives way, what it pointed to stays.
  fs::create_symlink(dir_ / "victim", dir_ / "b");
  WriteFileAtomically(dir_ / "b", "new");
  EXPECT_EQ(ReadFile(dir_ / "victim"), "untouched");
  EXPECT_FALSE(fs::is_symlink(dir_ / "b"));
}

TEST_F(FilesTest, TemporaryNamesCannotBeForetoldAndAreNotInherited) {
  const TemporaryFile one(dir_ / "a"), two(dir_ / "a");
  EXPECT_EQ(Entries(), 2u);
  EXPECT_NE(fcntl(one.descriptor(), F_GETFD) & FD_CLOEXEC, 0);
}

TEST_F(FilesTest, TheFileIsSyncedBeforeTheRenameAndItsFolderAfter) {
  Synced().clear();
  WriteFileAtomically(dir_ / "a", "x");
  ASSERT_EQ(Synced().size(), 2u);
  EXPECT_TRUE(Synced()[0].starts_with((dir_ / "a.tmp").string())) << Synced()[0];
  EXPECT_EQ(Synced()[1], dir_.string());
}

TEST_F(FilesTest, WhatADeadProcessLeftIsSweptUp) {
  const pid_t child = fork();
  if (child == 0) {
    TemporaryFile left(dir_ / "map.atlas");
    _exit(0);  // as kill -9 would: nothing is cleaned up
  }
  waitpid(child, nullptr, 0);
  ASSERT_EQ(Entries(), 1u);
  EXPECT_EQ(RemoveStaleTemporaries(dir_), 1u);
  EXPECT_EQ(Entries(), 0u);
  EXPECT_EQ(RemoveStaleTemporaries(dir_ / "nowhere"), 0u);
}

TEST_F(FilesTest, WhatIsBeingWrittenIsNotSweptUp) {
  const TemporaryFile ours(dir_ / "a");
  // As by a process of another machine on a shared disk: no such process here.
  const fs::path theirs = dir_ / "b.tmp999999999-0123456789abcdef";
  Plant(theirs.filename(), "");
  const int file = open(theirs.c_str(), O_RDWR);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  EXPECT_EQ(RemoveStaleTemporaries(dir_), 0u);
  EXPECT_EQ(Entries(), 2u);
  close(file);
  EXPECT_EQ(RemoveStaleTemporaries(dir_), 1u);
  EXPECT_FALSE(fs::exists(theirs));
}

TEST_F(FilesTest, FilesOfOthersWithSimilarNamesAreKept) {
  for (const char* name : {"notes.tmp1", "a.tmp999999999-short", "a.tmp-0123456789abcdef",
                           ".tmp999999999-0123456789abcdef", "a.tmp999999999-0123456789ABCDEF"}) {
    Plant(name, "");
  }
  Plant("victim", "");
  fs::create_symlink(dir_ / "victim", dir_ / "a.tmp999999999-0123456789abcdef");
  EXPECT_EQ(RemoveStaleTemporaries(dir_), 0u);
  EXPECT_EQ(Entries(), 7u);
}

}  // namespace
}  // namespace atlas::core
