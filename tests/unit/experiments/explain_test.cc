// What `atlas explain` prints: a line a parameter that depends on that parameter alone.
#include <gtest/gtest.h>

#include <sstream>

#include "core/errors.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/map_commands.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {
namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Explained(const std::vector<std::string>& assignments,
                                   const std::vector<std::string>& prefixes = {}) {
  return LinesOf(ExplainText(LoadExperiment("car", assignments).rows, prefixes));
}

TEST(Explain, OneValueChangesOneLine) {
  const std::vector<std::string> before = Explained({}),
                                 after = Explained({"planner.commit_margin=0.123456789"});
  ASSERT_EQ(before.size(), after.size());
  int changed = 0;
  for (size_t i = 0; i < before.size(); ++i) changed += before[i] != after[i];
  EXPECT_EQ(changed, 1);
  EXPECT_EQ(before.size(), LoadExperiment("car", {}).rows.size());
}

TEST(Explain, ALineHoldsKeyValueUnitRangeOriginAndMeaning) {
  EXPECT_EQ(Explained({"mission.max_time_s=60"}, {"mission.max_time_s"}).at(0),
            "mission.max_time_s = 60 s | [1, 1000000] | --set mission.max_time_s=60 | simulated time budget");
  EXPECT_TRUE(Explained({}, {"scene.name"}).at(0).starts_with("scene.name = car |  | car.yaml:"));
}

TEST(Explain, PrefixesChooseSectionsAndKeys) {
  const std::vector<std::string> lines = Explained({}, {"planner.terrain", "mission.max_s"});
  EXPECT_GT(lines.size(), 5u);
  int mission = 0;
  for (const std::string& line : lines) {
    mission += line.starts_with("mission.max_scans = ");
    EXPECT_TRUE(line.starts_with("planner.terrain.") || line.starts_with("mission.max_s")) << line;
  }
  EXPECT_EQ(mission, 1);
  try {
    Explained({}, {"planer"});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'planner'"), std::string::npos) << error.what();
  }
}

TEST(Explain, TheMapperOfRecordedLogsIsExplainedToo) {
  MapArguments arguments;
  arguments.assignments = {"mapper.lambda_r=0.03"};
  const std::vector<core::ParamRow> rows = ExplainMap(arguments);
  EXPECT_GT(rows.size(), 15u);
  const std::vector<std::string> lines = LinesOf(ExplainText(rows, {"mapper.lambda_r"}));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].starts_with("mapper.lambda_r = 0.03 | [0, 1] | --set mapper.lambda_r=0.03 | "))
      << lines[0];
}

TEST(Explain, EveryParameterSaysWhatItMeans) {
  for (const core::ParamRow& row : LoadExperiment("car", {}).rows) EXPECT_GT(row.doc.size(), 8u) << row.path;
  for (const core::ParamRow& row : ExplainMap({})) EXPECT_GT(row.doc.size(), 8u) << row.path;
}

}  // namespace
}  // namespace atlas::experiments
