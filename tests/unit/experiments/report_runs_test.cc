#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/judge/metric.h"
#include "experiments/report/report.h"
#include "experiments/results/run_recorder.h"
#include "tests/support/run_summaries.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

using atlas::tests::RunOf;

class ReportTest : public ::testing::Test {
 protected:
  ReportTest() : root_(fs::temp_directory_path() / "atlas_report_test") { fs::remove_all(root_); }
  ~ReportTest() override { fs::remove_all(root_); }

  void WriteRun(const std::string& name, const RunSummary& summary) const {
    RunRecorder recorder(root_ / name, summary, {StepColumns(), TimesColumns()});
    for (int scan = 1; scan <= 5; ++scan) {
      core::Row step;
      for (const char* column : {"distance_m", "coverage_raw"}) step.Set(column, 0.0);
      step.Set("scan", scan);
      step.Set("sim_time_s", 40.0 * scan);
      step.Set("coverage", *summary.Number("coverage") * (1.0 - 1.0 / (1.0 + scan)));
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

TEST_F(ReportTest, NamesOfExperimentsNeverLeadOutOfItsFolder) {
  int seed = 0;
  for (const char* experiment :
       {"x/../../../escaped", "x/../..", "/tmp/escaped", "..", "a b", "a-b", "-rf"}) {
    WriteRun("runs/" + std::to_string(++seed), RunOf(experiment, 1, 0.7));
  }
  const auto files = [&] {
    size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(root_)) count += entry.is_regular_file();
    return count;
  };
  const size_t before = files();
  fs::create_directories(root_ / "deep/er/out/coverage_x");  // as a path through it would need
  std::ostringstream log;
  EXPECT_EQ(RunReport({root_ / "runs"}, root_ / "deep/er/out", log), 0);
  size_t plots = 0, inside = 0;
  for (const auto& entry : fs::directory_iterator(root_ / "deep/er/out")) {
    plots += entry.path().extension() == ".svg";
    inside += entry.is_regular_file();
  }
  EXPECT_EQ(plots, 7u);  // each its own
  EXPECT_EQ(files(), before + inside);
  EXPECT_FALSE(fs::exists("/tmp/escaped.svg"));
}

TEST_F(ReportTest, RunsWithControlCharactersAreLeftOutByName) {
  WriteRun("good/1", RunOf("car", 1, 0.7));
  WriteRun("bad/1", RunOf("c\x1b[2Jar", 1, 0.7));
  std::ostringstream log;
  EXPECT_EQ(RunReport({root_}, root_ / "out", log), 0);
  EXPECT_NE(log.str().find("holds a control character: 'c\\x1b[2Jar'"), std::string::npos);
  EXPECT_EQ(log.str().find('\x1b'), std::string::npos);
}

TEST_F(ReportTest, FoldersWithoutAnyRunAreBadInput) {
  fs::create_directories(root_);
  std::ostringstream log;
  EXPECT_THROW(RunReport({root_}, root_, log), core::InputError);
  EXPECT_THROW(RunReport({root_ / "absent"}, root_, log), core::InputError);
  EXPECT_THROW(RunReport({}, root_, log), core::InputError);
}

}  // namespace
}  // namespace atlas::experiments
