// The map of the house, kept true by reading the sources.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/support/source_tree.h"

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = atlas::tests::SourceTree();
const std::vector<std::string> kRooms = {"core",    "scenes",  "robots",      "sim",
                                         "mapping", "planner", "experiments", "tests"};

std::string Read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::vector<fs::path> Sources() {
  std::vector<fs::path> files;
  for (const std::string& room : kRooms) {
    for (const auto& file : fs::recursive_directory_iterator(kRoot / room)) {
      const std::string extension = file.path().extension();
      if (extension == ".h" || extension == ".cc") files.push_back(fs::relative(file.path(), kRoot));
    }
  }
  return files;
}

std::vector<std::string> IncludesOf(const fs::path& file) {
  std::vector<std::string> includes;
  const std::string text = Read(kRoot / file);
  static const std::regex kInclude("(?:^|\n)#include [<\"]([^>\"]+)[>\"]");
  for (std::sregex_iterator it(text.begin(), text.end(), kInclude), end; it != end; ++it)
    includes.push_back((*it)[1]);
  return includes;
}

std::string RoomOf(const std::string& path) {
  return path.substr(0, path.find('/'));
}

TEST(HouseRules, RoomsIncludeOnlyTheRoomsBelowThem) {
  const std::map<std::string, std::set<std::string>> allowed = {
      {"core", {"core"}},
      {"scenes", {"core", "scenes"}},
      {"robots", {"core", "robots"}},
      {"sim", {"core", "scenes", "robots", "sim"}},
      {"mapping", {"core", "mapping"}},
      {"planner", {"core", "mapping", "planner"}},
      {"experiments", {"core", "scenes", "robots", "sim", "mapping", "planner", "experiments"}},
      {"tests", {kRooms.begin(), kRooms.end()}}};
  const std::set<std::string> rooms(kRooms.begin(), kRooms.end());
  size_t checked = 0;
  for (const fs::path& file : Sources()) {
    for (const std::string& include : IncludesOf(file)) {
      if (rooms.count(RoomOf(include)) == 0 || include.find('/') == std::string::npos) continue;
      ++checked;
      EXPECT_EQ(allowed.at(RoomOf(file.string())).count(RoomOf(include)), 1u)
          << file << " includes " << include;
    }
  }
  EXPECT_GT(checked, 100u);
}

/// The folders of rooms (and of a trade of several stages) that hold several trades, each above those before
/// it.
const std::map<std::string, std::vector<std::string>> kTrades = {
    {"scenes", {"build", "town"}},
    {"sim", {"world", "render", "sensors", "locomotion", "walking"}},
    {"mapping",
     {"cloud", "octree", "grid", "integrator", "meshing", "io", "terrain", "slam", "atlas", "backends"}},
    {"mapping/integrator", {"projection", "measurement", "free_space", "surface", "write", "rays"}},
    {"planner", {"gain", "views", "graph", "travel", "stopping", "planners"}},
    {"experiments",
     {"identity", "results", "judge", "video", "mission", "report", "sweep", "record", "mapping_tools",
      "bench", "cli"}}};

/// The place of a file's folder among those of `house`. Of the house's own files, headers are what all trades
/// share and stand below them; what is built of all stands above.
size_t PlaceOf(const std::string& path, const std::string& house) {
  const std::vector<std::string>& trades = kTrades.at(house);
  const size_t begin = house.size() + 1, end = path.find('/', begin);
  if (end == std::string::npos) return path.ends_with(".cc") ? trades.size() + 1 : 0;
  const auto found = std::find(trades.begin(), trades.end(), path.substr(begin, end - begin));
  EXPECT_NE(found, trades.end()) << path << ": a folder without a place (kTrades)";
  return static_cast<size_t>(found - trades.begin()) + 1;
}

bool GoesUp(const std::string& file, const std::string& include) {
  return std::any_of(kTrades.begin(), kTrades.end(), [&](const auto& house) {
    const std::string within = house.first + "/";
    return file.starts_with(within) && include.starts_with(within) &&
           PlaceOf(include, house.first) > PlaceOf(file, house.first);
  });
}

TEST(HouseRules, FoldersIncludeOnlyTheFoldersBelowThem) {
  EXPECT_TRUE(GoesUp("experiments/judge/coverage.cc", "experiments/mission/ending.h"));
  EXPECT_TRUE(GoesUp("planner/planner.h", "planner/graph/roadmap.h"));
  EXPECT_FALSE(GoesUp("planner/graph/roadmap.h", "planner/planner.h"));
  EXPECT_FALSE(GoesUp("experiments/mission/ending.cc", "experiments/judge/coverage.h"));
  EXPECT_FALSE(GoesUp("experiments/judge/align.cc", "experiments/judge/align.h"));
  EXPECT_TRUE(GoesUp("mapping/integrator/projection/scan_remap.cc", "mapping/integrator/write/chunk_fill.h"));
  EXPECT_FALSE(GoesUp("mapping/integrator/write/chunk_fill.h", "mapping/integrator/surface/hit_scatter.h"));
  size_t arrows = 0;
  for (const fs::path& file : Sources()) {
    for (const std::string& include : IncludesOf(file)) {
      arrows += RoomOf(file.string()) == RoomOf(include);
      EXPECT_FALSE(GoesUp(file.string(), include)) << file << " includes " << include;
    }
  }
  EXPECT_GT(arrows, 500u);
}

TEST(HouseRules, ThirdPartyHeadersStayInTheirRoom) {
  const std::vector<std::pair<std::regex, std::regex>> rules = {
      {std::regex("mujoco/.*|EGL/.*|GL/.*"), std::regex("(sim/.*\\.cc|tests/.*)")},
      {std::regex("embree[34]/.*"), std::regex("sim/sensors/embree\\.h")},
      {std::regex("octomap/.*"), std::regex("(mapping/backends/octomap_.*|tests/.*)")},
      {std::regex("ompl/.*"), std::regex("planner/views/ompl_bridge\\.cc")},
      {std::regex("ceres/.*"), std::regex("(mapping/slam/.*\\.cc|tests/.*)")}};
  size_t matched = 0;
  for (const fs::path& file : Sources()) {
    for (const std::string& include : IncludesOf(file)) {
      for (const auto& [header, place] : rules) {
        if (!std::regex_match(include, header)) continue;
        ++matched;
        EXPECT_TRUE(std::regex_match(file.string(), place)) << file << " includes " << include;
      }
    }
  }
  EXPECT_GT(matched, 3u);
}

TEST(HouseRules, LibrariesNeverPrint) {
  const std::regex prints("std::(cout|cerr|clog)|[^a-z]printf\\(|fmt::print");
  for (const fs::path& file : Sources()) {
    const std::string room = RoomOf(file.string());
    if (room == "experiments" || room == "tests") continue;
    EXPECT_FALSE(std::regex_search(Read(kRoot / file), prints)) << file;
  }
}

TEST(HouseRules, EquationIndexIsTrue) {
  const std::string index = Read(kRoot / "docs/equations.md");
  const std::regex row("\\| Eq\\. ([0-9.]+)[^|]*\\|[^|]*\\| `([^`]+)` \\|");
  size_t rows = 0;
  for (std::sregex_iterator it(index.begin(), index.end(), row), end; it != end; ++it) {
    const fs::path file = kRoot / (*it)[2].str();
    ++rows;
    ASSERT_TRUE(fs::exists(file)) << file;
    EXPECT_NE(Read(file).find("Eq. " + (*it)[1].str()), std::string::npos)
        << file << " does not name Eq. " << (*it)[1].str();
  }
  EXPECT_GE(rows, 8u);
}

TEST(HouseRules, SourcesAreFormatted) {
  ASSERT_EQ(std::system("clang-format --version > /dev/null 2>&1"), 0) << "clang-format is not installed";
  if (std::system("clang-format --version | grep -q 'version 14\\.'") != 0)
    GTEST_SKIP() << "releases of clang-format differ; the sources are laid out by that of Debian 12 (14)";
  const std::string command =
      "cd '" + kRoot.string() +
      "' && git ls-files '*.h' '*.cc' | xargs clang-format --dry-run -Werror > /dev/null 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << "run: git ls-files '*.h' '*.cc' | xargs clang-format -i";
}

}  // namespace
