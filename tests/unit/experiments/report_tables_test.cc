#include "experiments/report/tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "experiments/report/run_groups.h"
#include "experiments/report/thesis_anchors.h"
#include "experiments/results/svg_plot.h"
#include "tests/support/run_summaries.h"

namespace atlas::experiments {
namespace {

using atlas::tests::Cell;
using atlas::tests::RunOf;

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

GroupedRuns Grouped(const std::vector<RunSummary>& summaries) {
  std::vector<ReportedRun> runs;
  for (const RunSummary& summary : summaries) runs.push_back(RunOfSummary(summary));
  return GroupRuns(runs);
}

bool HasNote(const TextTable& table, const std::string& words) {
  return std::any_of(table.notes.begin(), table.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

TEST(Tables, OneRunReadsAsTable31WithTheThesisBeneath) {
  const std::string table = CoverageTable(Grouped({RunOf("helicopter", 1, 0.8612)}));
  EXPECT_NE(table.find("86.12"), std::string::npos);
  EXPECT_NE(table.find("12:26"), std::string::npos);
  EXPECT_NE(table.find("completed (gain_exhausted)"), std::string::npos);
  EXPECT_NE(table.find("thesis, Table 3.1"), std::string::npos);
  EXPECT_NE(table.find("83.76"), std::string::npos);
}

TEST(Tables, ThreeSeedsShowTheConfidenceIntervalOfTheirMean) {
  // 70, 71, 72: s = 1, t(0.975, 2) = 4.3027 of the printed tables, so 4.3027 / sqrt(3) = 2.484.
  const TextTable table = GroupTable(
      Grouped({RunOf("car", 1, 0.70), RunOf("car", 2, 0.71), RunOf("car", 3, 0.72), RunOf("house", 1, 0.6)}));
  EXPECT_EQ(Cell(table, 0, "c_p %"), "71.00 ± 2.48");
  EXPECT_EQ(Cell(table, 0, "runs"), "3");
  EXPECT_EQ(Cell(table, 0, "status"), "3 completed (gain_exhausted)");
  EXPECT_TRUE(HasNote(table, "95 % confidence interval (t distribution)"));
}

TEST(Tables, TwoSeedsShowBothAndOneShowsNoInterval) {
  const TextTable table =
      GroupTable(Grouped({RunOf("shed", 1, 0.70), RunOf("shed", 2, 0.72), RunOf("barn", 1, 0.6)}));
  EXPECT_EQ(Cell(table, 0, "c_p %"), "71.00 [70.00, 72.00]");
  EXPECT_EQ(Cell(table, 1, "c_p %"), "60.00");
  EXPECT_FALSE(HasNote(table, "confidence"));
}

TEST(Tables, ASingleFallAmongSeedsShows) {
  std::vector<RunSummary> runs = {RunOf("car", 1, 0.7), RunOf("car", 2, 0.3)};
  runs[1].status = RunStatus::kRobotFell;
  runs[1].stop_reason = StopReason::kFell;
  runs[1].numbers.Set("falls", 1);
  const TextTable table = GroupTable(Grouped(runs));
  EXPECT_EQ(Cell(table, 0, "falls"), "1");
  EXPECT_EQ(Cell(table, 0, "status"), "1 completed (gain_exhausted), 1 robot_fell (fell)");
}

TEST(Tables, FallsThatNothingMeasuredAreNotZero) {
  RunSummary run = RunOf("shed", 1, 0.7);
  for (const char* key : {"falls", "collisions"}) run.numbers.Set(key, std::optional<double>());
  const TextTable table = GroupTable(Grouped({run}));
  EXPECT_EQ(Cell(table, 0, "falls"), "-");
  EXPECT_EQ(Cell(table, 0, "collisions"), "-");
}

TEST(Tables, ColumnsOfWhatNoRunMeasuredAreLeftOut) {
  RunSummary run = RunOf("shed", 1, 0.7);
  const auto has = [](const TextTable& table, const std::string& heading) {
    return std::count(table.heading.begin(), table.heading.end(), heading) > 0;
  };
  EXPECT_FALSE(has(GroupTable(Grouped({run})), "error mm"));
  run.numbers.Set("cloud_error_m_mean", 0.0123);
  const TextTable table = GroupTable(Grouped({run, RunOf("barn", 1, 0.5)}));
  EXPECT_EQ(Cell(table, 0, "error mm"), "12.3");
  EXPECT_EQ(Cell(table, 1, "error mm"), "-");
}

TEST(Tables, KinematicRunsAreNamedAndNeverMixed) {
  std::vector<RunSummary> runs = {RunOf("car", 1, 0.7), RunOf("car", 2, 0.7)};
  runs[1].locomotion = "kinematic";
  const TextTable table = GroupTable(Grouped(runs));
  ASSERT_EQ(table.rows.size(), 3u);  // and the thesis's
  EXPECT_EQ(Cell(table, 0, "planner"), "greedy locomotion=trot");
  EXPECT_EQ(Cell(table, 1, "planner"), "greedy locomotion=kinematic");
}

TEST(Tables, WordsOfTheSummariesStandOnceWhereAllAgreeElseByTheirRows) {
  std::vector<RunSummary> runs = {RunOf("shed", 1, 0.7), RunOf("shed", 1, 0.6)};
  runs[1].planner = "thesis";
  runs[0].odometry = runs[1].odometry = "legs";
  runs[0].render_backend = "egl";
  runs[1].render_backend = "osmesa";
  const TextTable table = GroupTable(Grouped(runs));
  EXPECT_TRUE(HasNote(table, "all rows: seeds: 1; locomotion: trot; odometry: legs; mapper: octomap"));
  EXPECT_TRUE(HasNote(table, "render_backend: greedy: egl; thesis: osmesa"));
  runs.push_back(RunOf("shed", 2, 0.7));
  runs.back().odometry = "legs";
  runs.back().mapper = "se_atlas";
  EXPECT_TRUE(HasNote(GroupTable(Grouped(runs)),
                      "mapper: greedy mapper=octomap, thesis: octomap; greedy mapper=se_atlas: se_atlas"));
  const TextTable data = GroupTable(Grouped(runs), Words::kColumns);
  EXPECT_EQ(Cell(data, 1, "render_backend"), "osmesa");
  EXPECT_FALSE(HasNote(data, "osmesa"));
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

}  // namespace
}  // namespace atlas::experiments
