// Damaged files of every kind: each is read, or refused in one line that names it. Neither a crash, nor
// memory that the file's size does not warrant, nor a reader that does not come to an end.
//
// The cases depend on the seed alone; how many are tried depends on $ATLAS_FUZZ_SECONDS of processor time a
// reader (default 0.8), at most $ATLAS_FUZZ_CASES (default 5000), at least 50.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "core/errors.h"
#include "tests/fuzz/fuzzed_reader.h"
#include "tests/fuzz/mutate.h"

namespace atlas::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr double kSlowestCase_s = 5.0;

double Setting(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atof(text) : otherwise;
}

double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Makes room that no file here warrants fail, rather than the machine.
void LimitMemory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  constexpr rlim_t kLimitBytes = rlim_t{6} << 30;
  const rlimit limit = {kLimitBytes, RLIM_INFINITY};
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &limit), 0);
#endif
}

/// "" when `bytes` are read or refused as they should be, else what is wrong. `*refusal` is the error, if
/// any.
std::string Try(const FuzzedReader& reader, const std::string& bytes, const fs::path& file,
                std::string* refusal) {
  refusal->clear();
  if (reader.on_disk) std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  const double begin = ProcessorSeconds();
  try {
    reader.read(bytes, file);
  } catch (const core::InputError& error) {
    const std::string line = *refusal = error.what();
    if (line.find(reader.file_name) == std::string::npos) return "the error does not name the file: " + line;
    if (line.find('\n') != std::string::npos) return "the error has several lines: " + line;
  } catch (const std::exception& error) {
    return fmt::format("another exception than InputError: {}", error.what());
  }
  const double took = ProcessorSeconds() - begin;
  return took < kSlowestCase_s ? "" : fmt::format("took {:.1f} s", took);
}

void Fuzz(const FuzzedReader& reader, const fs::path& folder) {
  const fs::path file = folder / reader.file_name;
  std::string refusal;
  for (const std::string& seed : reader.seeds) {
    ASSERT_EQ(Try(reader, seed, file, &refusal), "");
    ASSERT_EQ(refusal, "") << reader.file_name << ": a good file";
  }
  core::Rng rng = core::Rng(1).Split(reader.file_name);
  const double end = ProcessorSeconds() + Setting("ATLAS_FUZZ_SECONDS", 0.8);
  const int most = static_cast<int>(Setting("ATLAS_FUZZ_CASES", 5000));
  int cases = 0, refusals = 0;
  for (; cases < most && (cases < 50 || ProcessorSeconds() < end); ++cases) {
    const std::string bytes = Mutated(reader.seeds, &rng);
    const std::string wrong = Try(reader, bytes, file, &refusal);
    const bool refused = !refusal.empty();
    refusals += refused;
    const bool same = std::find(reader.seeds.begin(), reader.seeds.end(), bytes) != reader.seeds.end();
    if (wrong.empty() && (refused || same || !reader.detects_every_change)) continue;
    const fs::path kept =
        fs::path(::testing::TempDir()) / fmt::format("fuzz_case_{}_{}", cases, reader.file_name);
    std::ofstream(kept, std::ios::binary) << bytes;
    ADD_FAILURE() << reader.file_name << ", case " << cases << ": "
                  << (wrong.empty() ? "damage went unseen" : wrong) << "\nkept as " << kept;
    return;
  }
  std::printf("    %-24s %5d cases, %5d refused\n", reader.file_name.c_str(), cases, refusals);
  EXPECT_GT(refusals, 0) << reader.file_name;
}

class Readers : public ::testing::Test {
 protected:
  Readers() : folder_(fs::path(::testing::TempDir()) / fmt::format("fuzz_{}", ::getpid())) {
    fs::create_directories(folder_);
    LimitMemory();
  }
  ~Readers() override { fs::remove_all(folder_); }
  void FuzzAll(const std::vector<FuzzedReader>& readers) {
    for (const FuzzedReader& reader : readers) Fuzz(reader, folder_);
  }
  fs::path folder_;
};

TEST_F(Readers, OfRecordedLogsReadOrRefuse) {
  FuzzAll(LogReaders());
}
TEST_F(Readers, OfMapsReadOrRefuse) {
  FuzzAll(MapReaders());
}
TEST_F(Readers, OfScenesReadOrRefuse) {
  FuzzAll(SceneReaders());
}
TEST_F(Readers, OfRunsReadOrRefuse) {
  FuzzAll(RunReaders());
}

}  // namespace
}  // namespace atlas::fuzz
