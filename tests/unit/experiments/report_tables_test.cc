#include "experiments/report/mapper_pairs.h"
#include "experiments/report/tables.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/report/report.h"
#include "experiments/report/svg_plot.h"
#include "experiments/report/thesis_anchors.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

RunSummary RunOf(const std::string& experiment, uint64_t seed, double coverage) {
  RunSummary s;
  s.experiment = experiment;
  s.gain = "occlusion_aware";
  s.planner = "greedy";
  s.mapper = "octomap";
  s.locomotion = "trot";
  s.seed = seed;
  s.status = RunStatus::kCompleted;
  s.stop_reason = StopReason::kGainExhausted;
  s.coverage = coverage;
  s.coverage_attainable = 0.9;
  s.coverage_of_attainable = coverage / 0.9;
  s.travel_distance_m = 40.0;
  s.scans = 11;
  s.sim_time_s = 746.4;
  s.nbv_time_s_mean = 0.5;
  s.real_time_factor = 9.0;
  s.falls = 0;
  s.collisions = 0;
  return s;
}

/// Whether tags nest and close, attributes are quoted and no bare & stands in text: a small XML reader.
bool WellFormed(const std::string& xml) {
  std::vector<std::string> open;
  for (size_t i = 0; i < xml.size(); ++i) {
    if (xml[i] == '&' && xml.find(';', i) > i + 7) return false;
    if (xml[i] != '<') continue;
    const size_t end = xml.find('>', i);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(i + 1, end - i - 1);
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return false;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" />", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != name) return false;
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
    i = end;
  }
  return open.empty();
}

TEST(Tables, OneRunReadsAsTable31WithTheThesisBeneath) {
  const std::string table = CoverageTable(std::vector<RunSummary>{RunOf("helicopter", 1, 0.8612)});
  EXPECT_NE(table.find("86.12"), std::string::npos);
  EXPECT_NE(table.find("12:26"), std::string::npos);
  EXPECT_NE(table.find("completed (gain_exhausted)"), std::string::npos);
  EXPECT_NE(table.find("thesis, Table 3.1"), std::string::npos);
  EXPECT_NE(table.find("83.76"), std::string::npos);
}

TEST(Tables, SeedsAreGroupedToMeanAndSampleDeviation) {
  const auto groups = GroupRuns(
      std::vector<RunSummary>{RunOf("car", 1, 0.70), RunOf("car", 2, 0.72), RunOf("house", 1, 0.6)});
  ASSERT_EQ(groups.size(), 2u);
  const TextTable table = GroupTable(groups, false);
  EXPECT_EQ(table.rows[0][3], "71.00 ± 1.41");
  EXPECT_EQ(table.rows[0][13], "2");
  EXPECT_EQ(table.rows[1][3], "60.00");
  EXPECT_EQ(table.rows[0][14], "2 completed");
}

TEST(Tables, ASingleFallAmongSeedsShows) {
  std::vector<RunSummary> runs = {RunOf("car", 1, 0.7), RunOf("car", 2, 0.3)};
  runs[1].status = RunStatus::kRobotFell;
  runs[1].falls = 1;
  const TextTable table = GroupTable(GroupRuns(runs), false);
  EXPECT_EQ(table.rows[0][11], "1");
  EXPECT_EQ(table.rows[0][14], "1 completed, 1 robot_fell");
}

TEST(Tables, KinematicRunsAreNamedAndNeverMixed) {
  std::vector<RunSummary> runs = {RunOf("car", 1, 0.7), RunOf("car", 2, 0.7)};
  runs[1].locomotion = "kinematic";
  const TextTable table = GroupTable(GroupRuns(runs), false);
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][2], "greedy [kinematic]");
}

TEST(Tables, TerminalColumnsLineUpDespiteMultibyteCharacters) {
  TextTable table;
  table.heading = {"a", "value"};
  table.left = {true, false};
  table.rows = {{"x", "1.0 ± 0.1"}, {"longer", "2"}};
  std::stringstream lines(ToTerminal(table));
  std::vector<size_t> widths;
  for (std::string line; std::getline(lines, line);) {
    widths.push_back(static_cast<size_t>(std::count_if(
        line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; })));
  }
  EXPECT_EQ(std::set<size_t>(widths.begin(), widths.end()).size(), 1u);
}

TEST(Tables, WritersEscapeWhatTheirFormatReserves) {
  TextTable table;
  table.heading = {"a_b", "c"};
  table.left = {true, false};
  table.rows = {{"x|y, \"z\"", "5 ± 1 %"}};
  EXPECT_NE(ToLatex(table).find("a\\_b & c"), std::string::npos);
  EXPECT_NE(ToLatex(table).find("5 $\\pm$ 1 \\%"), std::string::npos);
  EXPECT_NE(ToMarkdown(table).find("x\\|y"), std::string::npos);
  EXPECT_NE(ToCsv(table).find("\"x|y, \"\"z\"\"\",5 ± 1 %"), std::string::npos);
}

TEST(ThesisAnchors, HoldTheTenPublishedRows) {
  EXPECT_EQ(ThesisRows().size(), 10u);
  EXPECT_EQ(FindThesisRow("facade", "rear_side_entropy")->coverage_percent, 94.24);
  EXPECT_EQ(FindThesisRow("helicopter_grating", "occlusion_aware")->scans, 26);
  EXPECT_EQ(FindThesisRow("car", "occlusion_aware_normalised")->scans, 8);
  EXPECT_FALSE(FindThesisRow("car", "unknown_volume").has_value());
}

TEST(SvgPlot, IsWellFormedAndEscapesText) {
  const std::string svg =
      PlotSvg({{.label = "a < b & \"c\"", .x = {1, 2, 3}, .y = {10, 20, 15}},
               {.label = "band", .x = {1, 2}, .y = {5, 6}, .y_low = {4, 5}, .y_high = {6, 7}}},
              {.title = "<t>", .x_label = "x", .y_label = "y & z", .x_range = {}, .y_range = {}});
  EXPECT_TRUE(WellFormed(svg));
  EXPECT_NE(svg.find("a &lt; b &amp; &quot;c&quot;"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(SvgPlot, SurvivesEmptyConstantAndBrokenSeries) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(WellFormed(PlotSvg({}, {})));
  EXPECT_TRUE(WellFormed(PlotSvg({{.label = "one", .x = {1}, .y = {5}}}, {})));
  const std::string broken = PlotSvg({{.label = "gap", .x = {1, 2, 3}, .y = {1, nan, 3}}}, {});
  EXPECT_TRUE(WellFormed(broken));
  EXPECT_EQ(broken.find("nan"), std::string::npos);
}

TEST(SvgPlot, TicksAreRoundAndInside) {
  EXPECT_EQ(RoundTicks(0, 100, 5, false), (std::vector<double>{0, 20, 40, 60, 80, 100}));
  EXPECT_EQ(RoundTicks(1, 12, 8, true), (std::vector<double>{2, 4, 6, 8, 10, 12}));
  EXPECT_EQ(RoundTicks(1, 3, 8, true), (std::vector<double>{1, 2, 3}));
}

class ReportTest : public ::testing::Test {
 protected:
  ReportTest() : root_(fs::temp_directory_path() / "atlas_report_test") { fs::remove_all(root_); }
  ~ReportTest() override { fs::remove_all(root_); }

  void WriteRun(const std::string& name, const RunSummary& summary) const {
    RunRecorder recorder(root_ / name, summary);
    for (int scan = 1; scan <= 5; ++scan) {
      StepRow step;
      step.scan = scan;
      step.sim_time_s = 40.0 * scan;
      step.coverage = *summary.coverage * (1.0 - 1.0 / (1.0 + scan));
      recorder.AddStep(step, {});
    }
    core::WriteFileAtomically(root_ / name / "summary.json", ToJson(summary));
  }
  fs::path root_;
};

TEST_F(ReportTest, CollectsRunsBelowAndLeavesDamagedOnesOutByName) {
  WriteRun("car/1", RunOf("car", 1, 0.70));
  WriteRun("car/2", RunOf("car", 2, 0.74));
  WriteRun("house/1", RunOf("house", 1, 0.60));
  WriteRun("house/2", RunOf("house", 2, 0.60));
  core::WriteFileAtomically(root_ / "house/2/summary.json", "{\"experiment\"");
  std::ostringstream log;
  EXPECT_EQ(RunReport({root_}, root_ / "out", log), 0);
  EXPECT_NE(log.str().find("left out: "), std::string::npos);
  EXPECT_NE(log.str().find("house/2/summary.json"), std::string::npos);
  EXPECT_NE(log.str().find("72.00 ± 2.83"), std::string::npos);
  const std::string html = core::ReadFile(root_ / "out/report.html");
  EXPECT_NE(html.find("72.00 ± 2.83"), std::string::npos);
  EXPECT_EQ(html.find("src="), std::string::npos);  // self-contained
  EXPECT_EQ(html.find("href="), std::string::npos);
  EXPECT_NE(html.find("<svg"), std::string::npos);
  for (const char* name : {"table.md", "table.csv", "table.tex", "runs.csv", "statistics.csv",
                           "coverage_car.svg", "coverage_house.svg"}) {
    EXPECT_TRUE(fs::exists(root_ / "out" / name)) << name;
  }
}

TEST_F(ReportTest, FoldersWithoutAnyRunAreBadInput) {
  fs::create_directories(root_);
  std::ostringstream log;
  EXPECT_THROW(RunReport({root_}, root_, log), core::InputError);
  EXPECT_THROW(RunReport({root_ / "absent"}, root_, log), core::InputError);
  EXPECT_THROW(RunReport({}, root_, log), core::InputError);
}

TEST(MapperPairs, AreComparedAtTheirEndsAndAfterEqualScans) {
  const auto run = [](const std::string& mapper, uint64_t seed, std::vector<double> coverage, double nbv_s) {
    RunWithCurve run;
    run.summary = RunOf("car", seed, coverage.back());
    run.summary.mapper = mapper;
    run.summary.nbv_time_s_mean = nbv_s;
    run.curve.coverage = std::move(coverage);
    return run;
  };
  const std::vector<RunWithCurve> runs = {
      run("octomap", 1, {0.2, 0.5, 0.8}, 1.0), run("se_atlas", 1, {0.3, 0.6}, 0.5),
      run("octomap", 2, {0.2, 0.4}, 1.0), run("se_atlas", 2, {0.2, 0.5, 0.7}, 1.0),
      run("se_atlas", 3, {0.2, 0.5, 0.7}, 1.0)};
  const TextTable table = MapperPairsTable(runs);
  ASSERT_EQ(table.rows.size(), 1u);
  const std::vector<std::string>& row = table.rows[0];
  EXPECT_EQ(row[0], "car");
  EXPECT_EQ(row[3], "2");
  EXPECT_EQ(row[4], "+5.00");   // (-20 + 30) / 2
  EXPECT_EQ(row[5], "+10.00");  // (10 + 10) / 2
  EXPECT_EQ(row[6], "+0.0");
  EXPECT_EQ(row[7], "-");
  EXPECT_EQ(row[8], "0.75");
  EXPECT_TRUE(MapperPairsTable({runs[0], runs[2]}).rows.empty());
}

TEST(MapperPairs, DifferInTheMapperOnly) {
  const auto run = [](const std::string& mapper, const std::string& variant, double coverage) {
    RunWithCurve run;
    run.summary = RunOf("car", 1, coverage);
    run.summary.mapper = mapper;
    if (variant == "a=2") run.summary.integration_ms_mean = mapper == "octomap" ? 200.0 : 50.0;
    run.variant = variant;
    run.curve.coverage = {coverage};
    return run;
  };
  const TextTable table = MapperPairsTable({run("octomap", "a=1", 0.4), run("octomap", "a=2", 0.6),
                                            run("se_atlas", "a=1", 0.5), run("se_atlas", "a=2", 0.5)});
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_NE(table.rows[0][2].find("a=1"), std::string::npos);
  EXPECT_EQ(table.rows[0][4], "+10.00");
  EXPECT_EQ(table.rows[0][7], "-");
  EXPECT_EQ(table.rows[1][4], "-10.00");
  EXPECT_EQ(table.rows[1][7], "0.25");
}

}  // namespace
}  // namespace atlas::experiments
