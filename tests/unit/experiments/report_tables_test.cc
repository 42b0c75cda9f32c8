#include "experiments/report/mapper_pairs.h"
#include "experiments/report/tables.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/report/report.h"
#include "experiments/report/run_groups.h"
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

GroupedRuns Grouped(const std::vector<RunSummary>& summaries) {
  std::vector<ReportedRun> runs;
  for (const RunSummary& summary : summaries) runs.push_back(RunOfSummary(summary));
  return GroupRuns(runs);
}

/// The cell under `heading`; fails the test where there is no such column.
std::string Cell(const TextTable& table, size_t row, const std::string& heading) {
  for (size_t i = 0; i < table.heading.size(); ++i) {
    if (table.heading[i] == heading) return table.rows.at(row).at(i);
  }
  ADD_FAILURE() << "no column " << heading;
  return "";
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
  EXPECT_EQ(Cell(table, 0, "status"), "3 completed");
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
  runs[1].falls = 1;
  const TextTable table = GroupTable(Grouped(runs));
  EXPECT_EQ(Cell(table, 0, "falls"), "1");
  EXPECT_EQ(Cell(table, 0, "status"), "1 completed, 1 robot_fell");
}

TEST(Tables, FallsThatNothingMeasuredAreNotZero) {
  RunSummary run = RunOf("shed", 1, 0.7);
  run.falls = run.collisions = std::nullopt;
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
  run.cloud_error_m_mean = 0.0123;
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
  void WriteConfig(const std::string& name, const std::string& yaml) const {
    core::WriteFileAtomically(root_ / name / "config.yaml", yaml);
  }
  /// What `atlas report` prints of the folder.
  std::string Report() const {
    std::ostringstream log;
    EXPECT_EQ(RunReport({root_}, root_ / "out", log), 0);
    return log.str();
  }
  static size_t Count(const std::string& text, const std::string& words) {
    size_t count = 0;
    for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
    return count;
  }
  fs::path root_;
};

TEST_F(ReportTest, RunsThatDifferInTheResolutionOnlyAreTwoRowsAndTwoCurves) {
  for (const char* resolution : {"0.05", "0.1"}) {
    for (int seed = 1; seed <= 3; ++seed) {
      const std::string name = std::string(resolution) + "/" + std::to_string(seed);
      WriteRun(name, RunOf("shed", static_cast<uint64_t>(seed), resolution[2] == '0' ? 0.7 : 0.5));
      WriteConfig(name, std::string("mapper:\n  name: octomap\n  resolution_m: ") + resolution +
                            "\noutput:\n  video: " + (seed == 1 ? "true" : "false") + "\n");
    }
  }
  const std::string text = Report();
  EXPECT_NE(text.find("greedy mapper.resolution_m=0.05  70.00 ± 0.00"), std::string::npos) << text;
  EXPECT_NE(text.find("greedy mapper.resolution_m=0.1   50.00 ± 0.00"), std::string::npos) << text;
  const std::string plot = core::ReadFile(root_ / "out/coverage_shed.svg");
  EXPECT_EQ(Count(plot, "mapper.resolution_m=0.05</text>"), 1u);
  EXPECT_EQ(Count(plot, "mapper.resolution_m=0.1</text>"), 1u);
  EXPECT_EQ(Count(plot, "stroke-width=\"2\" stroke-linejoin"), 2u);  // curves
}

TEST_F(ReportTest, RunsOfTwoCommitsAreTwoRowsLabelledByTheCommitAlone) {
  for (const char* commit : {"aaa", "bbb"}) {
    RunSummary run = RunOf("shed", 1, 0.7);
    run.commit = commit;
    WriteRun(commit, run);
    std::string parameters;  // the later commit has parameters that the earlier one lacked
    for (int i = 0; i < 5 && run.commit == "bbb"; ++i) parameters += "  p" + std::to_string(i) + ": 1\n";
    WriteConfig(commit, "mapper:\n  name: octomap\n" + parameters);
  }
  const std::string text = Report();
  EXPECT_NE(text.find("greedy commit=aaa "), std::string::npos) << text;
  EXPECT_NE(text.find("greedy commit=bbb "), std::string::npos) << text;
  EXPECT_NE(text.find("rows also differ in mapper.p0, mapper.p1"), std::string::npos) << text;
}

TEST_F(ReportTest, MeansLeaveOutRunsWithoutResultAndSaySo) {
  const double coverage[] = {0.70, 0.71, 0.72, 0.10, 0.20};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    RunSummary run = RunOf("shed", seed, coverage[seed - 1]);
    if (seed == 4) run.status = RunStatus::kInterrupted;
    if (seed == 5) run.status = RunStatus::kFailed;
    WriteRun("shed/" + std::to_string(seed), run);
  }
  const std::string text = Report();
  EXPECT_NE(text.find("71.00 ± 2.48"), std::string::npos) << text;
  EXPECT_NE(text.find("left out, no result: shed/4 (interrupted), shed/5 (failed)"), std::string::npos)
      << text;
  const std::string runs = core::ReadFile(root_ / "out/runs.csv");
  EXPECT_EQ(Count(runs, "interrupted"), 1u);
  EXPECT_EQ(Count(runs, "\n"), 6u);
}

TEST_F(ReportTest, TheSameRunTwiceCountsOnce) {
  for (const char* name : {"shed/1", "shed/1-2", "shed/2", "shed/3"}) {
    WriteRun(name, RunOf("shed", static_cast<uint64_t>(name[5] - '0'), 0.7));
  }
  const std::string text = Report();
  EXPECT_NE(text.find("left out, same configuration and seed as another: shed/1-2"), std::string::npos)
      << text;
  EXPECT_NE(text.find("3 completed"), std::string::npos) << text;
}

TEST_F(ReportTest, NoNameOfAnExperimentLeavesTheFolder) {
  WriteRun("evil/1", RunOf("x/../../../evil", 1, 0.7));
  Report();
  for (const auto& file : fs::recursive_directory_iterator(root_.parent_path() / root_.filename())) {
    if (file.path().extension() != ".svg" || file.path().filename() == "coverage.svg") continue;
    EXPECT_EQ(file.path().parent_path(), root_ / "out");
  }
  size_t plots = 0;
  for (const auto& file : fs::directory_iterator(root_ / "out")) {
    plots += file.path().filename().string().starts_with("coverage_x-..-..");
  }
  EXPECT_EQ(plots, 1u);
}

TEST_F(ReportTest, TheTableNamesItsCommandAndItsWords) {
  WriteRun("shed/1", RunOf("shed", 1, 0.7));
  Report();
  const std::string table = core::ReadFile(root_ / "out/table.md");
  EXPECT_TRUE(table.starts_with("`./atlas report " + root_.string() + " --out ")) << table;
  EXPECT_NE(table.find("mapper: octomap"), std::string::npos);
  EXPECT_NE(core::ReadFile(root_ / "out/table.tex").find("mapper: octomap"), std::string::npos);
  EXPECT_NE(core::ReadFile(root_ / "out/report.html").find("mapper: octomap"), std::string::npos);
}

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
  EXPECT_NE(log.str().find("72.00 [70.00, 74.00]"), std::string::npos);
  const std::string html = core::ReadFile(root_ / "out/report.html");
  EXPECT_NE(html.find("72.00 [70.00, 74.00]"), std::string::npos);
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

class MapperPairsTest : public ::testing::Test {
 protected:
  void Add(const std::string& mapper, uint64_t seed, std::vector<double> coverage, double nbv_s,
           const std::string& resolution = "0.05") {
    RunSummary summary = RunOf("car", seed, coverage.back());
    summary.mapper = mapper;
    summary.nbv_time_s_mean = nbv_s;
    if (resolution == "0.1") summary.integration_ms_mean = mapper == "octomap" ? 200.0 : 50.0;
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
