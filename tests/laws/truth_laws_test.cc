// Who may read the simulator's ground truth: what judges a run and what films it, nothing that decides.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "core/files.h"
#include "tests/support/source_tree.h"

namespace atlas {
namespace {

namespace fs = std::filesystem;

/// Sources of the rooms above the simulator that hold one of these words.
std::set<std::string> FilesThatSay(const std::vector<std::string>& words) {
  std::set<std::string> found;
  const fs::path root = tests::SourceTree();
  for (const char* room : {"mapping", "planner", "experiments"}) {
    for (const auto& file : fs::recursive_directory_iterator(root / room)) {
      const std::string kind = file.path().extension();
      if (kind != ".h" && kind != ".cc") continue;
      const std::string text = core::ReadFile(file.path());
      for (const std::string& word : words) {
        if (text.find(word) != std::string::npos) found.insert(fs::relative(file.path(), root));
      }
    }
  }
  return found;
}

TEST(TruthLaw, OnlyTheJudgeTheFilmAndTheLocaliserTruthReadIt) {
  const std::set<std::string> readers = FilesThatSay({"TrueBasePose", "TrueState", "AddStateObserver"});
  const std::set<std::string> allowed = {
      "experiments/judge/mission_metrics.cc", "experiments/mission/run_film.cc",
      "experiments/mission/run_localiser.cc", "experiments/video/run_recording.h"};
  for (const std::string& file : readers) EXPECT_TRUE(allowed.count(file) > 0) << file;
  EXPECT_TRUE(readers.count("experiments/judge/mission_metrics.cc") > 0) << "or this test reads nothing";
}

}  // namespace
}  // namespace atlas
