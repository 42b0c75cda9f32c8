#include "experiments/report/mapper_pairs.h"

#include <gtest/gtest.h>

#include "tests/support/run_summaries.h"

namespace atlas::experiments {
namespace {

using atlas::tests::Cell;
using atlas::tests::RunOf;

class MapperPairsTest : public ::testing::Test {
 protected:
  void Add(const std::string& mapper, uint64_t seed, std::vector<double> coverage, double nbv_s,
           const std::string& resolution = "0.05") {
    RunSummary summary = RunOf("car", seed, coverage.back());
    summary.mapper = mapper;
    summary.numbers.Set("nbv_time_s_mean", nbv_s);
    if (resolution == "0.1") summary.numbers.Set("integration_ms_mean", mapper == "octomap" ? 200.0 : 50.0);
    ReportedRun run = RunOfSummary(summary);
    run.settings["mapper.resolution_m"] = resolution;
    if (mapper == "octomap") run.settings["mapper.hit_probability"] = "0.7";  // of this mapper alone
    run.curve.coverage = std::move(coverage);
    runs_.push_back(std::move(run));
  }
  TextTable Table() const { return MapperPairsTable(GroupRuns(runs_).groups); }

  std::vector<ReportedRun> runs_;
};

TEST_F(MapperPairsTest, AreComparedAtTheirEndsAndAfterEqualScans) {
  Add("octomap", 1, {0.2, 0.5, 0.8}, 1.0);
  Add("se_atlas", 1, {0.3, 0.6}, 0.5);
  Add("octomap", 2, {0.2, 0.4}, 1.0);
  Add("se_atlas", 2, {0.2, 0.5, 0.7}, 1.0);
  Add("se_atlas", 3, {0.2, 0.5, 0.7}, 1.0);
  const TextTable table = Table();
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(Cell(table, 0, "object"), "car");
  EXPECT_EQ(Cell(table, 0, "against"), "octomap");
  EXPECT_EQ(Cell(table, 0, "pairs"), "2");
  EXPECT_EQ(Cell(table, 0, "c_p at the end"), "+5.00 [-20.00, +30.00]");
  EXPECT_EQ(Cell(table, 0, "after equal scans"), "+10.00 [+10.00, +10.00]");
  EXPECT_EQ(Cell(table, 0, "scans"), "+0.0 [-1.0, +1.0]");
  EXPECT_EQ(Cell(table, 0, "integration"), "-");
  EXPECT_EQ(Cell(table, 0, "t_nbv"), "0.75 [0.50, 1.00]");
}

TEST_F(MapperPairsTest, OneMapperAloneHasNoPairs) {
  Add("octomap", 1, {0.2}, 1.0);
  Add("octomap", 2, {0.4}, 1.0);
  EXPECT_TRUE(Table().rows.empty());
}

TEST_F(MapperPairsTest, DifferInTheMapperOnly) {
  Add("octomap", 1, {0.4}, 1.0, "0.05");
  Add("octomap", 1, {0.6}, 1.0, "0.1");
  Add("se_atlas", 1, {0.5}, 1.0, "0.05");
  Add("se_atlas", 1, {0.5}, 1.0, "0.1");
  const TextTable table = Table();
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(Cell(table, 0, "planner"), "greedy mapper.resolution_m=0.05");
  EXPECT_EQ(Cell(table, 0, "c_p at the end"), "+10.00");
  EXPECT_EQ(Cell(table, 0, "integration"), "-");
  EXPECT_EQ(Cell(table, 1, "c_p at the end"), "-10.00");
  EXPECT_EQ(Cell(table, 1, "integration"), "0.25");
}

}  // namespace
}  // namespace atlas::experiments
