#include "experiments/sweep/sweep.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/sweep/slurm.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

// Stands in for `atlas`: counts its calls, writes a summary, or misbehaves when the experiment says so.
constexpr const char* kFakeAtlas = R"sh(#!/bin/bash
shift; experiment=$1; shift
gain=none; planner=none
while [ $# -gt 0 ]; do
  case $1 in
    --seed) seed=$2;;
    --out) out=$2;;
    --set) case $2 in planner.gain=*) gain=${2#*=};; planner.name=*) planner=${2#*=};; esac;;
  esac
  shift 2
done
mkdir -p "$out"; echo call >> "$out/calls"
case $experiment in
  crash) echo "out of luck"; exit 3;;
  killed) kill -9 $$;;
  slow) trap 'echo interrupted > "$out/trapped"; exit 130' INT; for i in $(seq 300); do sleep 0.1; done;;
  fell) status=robot_fell; code=1;;
  *) status=completed; code=0;;
esac
printf '{"experiment":"%s","gain":"%s","planner":"%s","seed":%d,"status":"%s","stop_reason":"explored",
"coverage":0.%d,"scans":9,"travel_distance_m":30,"sim_time_s":500,"wall_time_s":4.5,"falls":0,"collisions":0}' \
  "$experiment" "$gain" "$planner" "$seed" "$status" "$((70 + seed))" > "$out/summary.json"
exit $code
)sh";

class SweepTest : public ::testing::Test {
 protected:
  SweepTest() {
    root_ = fs::temp_directory_path() /
            ("atlas_sweep_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
    core::WriteFileAtomically(root_ / "atlas", kFakeAtlas);
    chmod((root_ / "atlas").c_str(), 0755);
    options_.executable = root_ / "atlas";
    options_.out = root_ / "out";
    options_.jobs = 4;
    spec_.name = "test";
    spec_.experiments = {"car"};
    spec_.grid = {{"planner.gain", {"occlusion_aware", "rear_side_entropy"}},
                  {"planner.name", {"thesis", "greedy"}}};
    spec_.seeds = {1, 2};
  }
  ~SweepTest() override { fs::remove_all(root_); }

  int Calls(const fs::path& run) const {
    const fs::path calls = options_.out / run / "calls";
    if (!fs::exists(calls)) return 0;
    const std::string text = core::ReadFile(calls);
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }
  std::string WriteSpec(const std::string& text) const {
    core::WriteFileAtomically(root_ / "spec.yaml", text);
    return (root_ / "spec.yaml").string();
  }
  std::string ErrorOf(const std::string& text) const {
    try {
      LoadSweep(WriteSpec(text));
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path root_;
  SweepSpec spec_;
  SweepOptions options_;
  std::ostringstream out_;
};

TEST_F(SweepTest, ExpandsToTheFullGridWithFoldersThatSayWhatTheyHold) {
  spec_.experiments = {"car", "house"};
  spec_.seeds = {1, 2, 3};
  const std::vector<SweepRun> runs = ExpandSweep(spec_, "out");
  ASSERT_EQ(runs.size(), 2u * 2u * 2u * 3u);
  EXPECT_EQ(runs[0].folder, fs::path("out/car_occlusion_aware_thesis/1"));
  EXPECT_EQ(runs[3].folder, fs::path("out/car_occlusion_aware_greedy/1"));
  EXPECT_EQ(runs.back().folder, fs::path("out/house_rear_side_entropy_greedy/3"));
  EXPECT_EQ(runs[3].assignments,
            (std::vector<std::string>{"planner.gain=occlusion_aware", "planner.name=greedy"}));
  EXPECT_TRUE(runs[0].variant.empty());
}

TEST_F(SweepTest, OtherSettingsBecomeVariantsInTables) {
  spec_.grid = {{"mapper.resolution_m", {"0.05", "0.1"}}};
  const std::vector<SweepRun> runs = ExpandSweep(spec_, "out");
  ASSERT_EQ(runs.size(), 4u);
  EXPECT_EQ(runs[2].variant, "mapper.resolution_m=0.1");
  EXPECT_EQ(runs[2].folder, fs::path("out/car_0.1/1"));
}

TEST_F(SweepTest, TheSweepsOfTheThesisLoad) {
  const SweepSpec one = LoadSweep("table_3_1");
  EXPECT_EQ(ExpandSweep(one, "x").size(), 4u * 2u * 2u * 3u);
  const SweepSpec two = LoadSweep("table_3_2");
  EXPECT_EQ(two.experiments, (std::vector<std::string>{"facade_grass", "helicopter_grating"}));
}

TEST_F(SweepTest, BadFilesAreNamedByFileLineFieldAndValue) {
  EXPECT_NE(
      ErrorOf("experiments: [car]\nseed: 3\n").find("spec.yaml:2: unknown key 'seed'; did you mean 'seeds'"),
      std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\n").find("'seeds' is missing"), std::string::npos);
  EXPECT_NE(ErrorOf("experiments: []\nseeds: 1\n").find("experiments: the list is empty"), std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: zero\n")
                .find("seeds: expected a number from 1 to 10000, found 'zero'"),
            std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 0\n").find("found '0'"), std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: [1, 1]\n").find("twice"), std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 1\ngrid: [a]\n").find("spec.yaml:3: grid"),
            std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 1\nset: [max]\n").find("set: expected a.b=value"),
            std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car\nseeds: 1\n").find("spec.yaml:"), std::string::npos);
  EXPECT_NE(ErrorOf("just text").find("expected keys"), std::string::npos);
  EXPECT_THROW(LoadSweep((root_ / "absent.yaml").string()), core::InputError);
  try {
    LoadSweep("table_3_3");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'table_3_"), std::string::npos);
  }
}

TEST_F(SweepTest, RunsEverythingOnceAndPrintsTheTable) {
  EXPECT_EQ(RunSweep(spec_, options_, out_), 0);
  for (const SweepRun& run : ExpandSweep(spec_, "")) EXPECT_EQ(Calls(run.folder), 1) << run.folder;
  EXPECT_NE(out_.str().find("8 runs, 0 done already, 4 at a time; estimated time 04:00"), std::string::npos);
  EXPECT_NE(out_.str().find("71.50 ± 0.71"), std::string::npos);
  EXPECT_NE(out_.str().find("thesis, Table 3.1"), std::string::npos);
  for (const char* name : {"table.md", "table.csv", "table.tex", "runs.csv", "statistics.csv"}) {
    EXPECT_TRUE(fs::exists(options_.out / name)) << name;
  }
}

TEST_F(SweepTest, ASecondCallRunsOnlyWhatIsNotFinal) {
  RunSweep(spec_, options_, out_);
  const fs::path lost = options_.out / "car_occlusion_aware_thesis/2",
                 stopped = options_.out / "car_occlusion_aware_greedy/1";
  fs::remove(lost / "summary.json");
  std::string text = core::ReadFile(stopped / "summary.json");
  text.replace(text.find("completed"), 9, "interrupted");
  core::WriteFileAtomically(stopped / "summary.json", text);
  std::ostringstream again;
  EXPECT_EQ(RunSweep(spec_, options_, again), 0);
  EXPECT_EQ(Calls("car_occlusion_aware_thesis/2"), 2);
  EXPECT_EQ(Calls("car_occlusion_aware_greedy/1"), 2);
  EXPECT_EQ(Calls("car_occlusion_aware_thesis/1"), 1);
  EXPECT_NE(again.str().find("6 done already"), std::string::npos);
  EXPECT_NE(again.str().find("from finished runs"), std::string::npos);
}

TEST_F(SweepTest, ChangedSettingsAreRunAgain) {
  RunSweep(spec_, options_, out_);
  spec_.set = {"mission.max_scans=5"};
  std::ostringstream again;
  RunSweep(spec_, options_, again);
  EXPECT_NE(again.str().find("8 runs, 0 done already"), std::string::npos);
}

TEST_F(SweepTest, FailuresAndFallsAreReportedNotHidden) {
  spec_.experiments = {"car", "crash", "killed", "fell"};
  spec_.grid.clear();
  spec_.seeds = {1};
  EXPECT_EQ(RunSweep(spec_, options_, out_), 1);
  EXPECT_NE(out_.str().find("FAILED (exit code 3): out of luck"), std::string::npos);
  EXPECT_NE(out_.str().find("FAILED (signal 9)"), std::string::npos);
  EXPECT_NE(out_.str().find("3 of 4 runs did not end well"), std::string::npos);
  EXPECT_NE(out_.str().find("fell/1: robot_fell"), std::string::npos);
  std::ostringstream again;  // a fall is final, a crash is not
  EXPECT_EQ(RunSweep(spec_, options_, again), 1);
  EXPECT_EQ(Calls("fell/1"), 1);
  EXPECT_EQ(Calls("crash/1"), 2);
}

TEST_F(SweepTest, StoppingEndsTheChildrenAndLeavesAResumableFolder) {
  spec_.experiments = {"slow"};
  spec_.grid.clear();
  spec_.seeds = {1, 2, 3};
  options_.jobs = 2;
  int polls = 0;
  options_.should_stop = [&] { return ++polls > 8; };
  EXPECT_EQ(RunSweep(spec_, options_, out_), 130);
  EXPECT_TRUE(fs::exists(options_.out / "slow/1/trapped"));
  EXPECT_TRUE(fs::exists(options_.out / "slow/2/trapped"));
  EXPECT_EQ(Calls("slow/3"), 0);
  for (const SweepRun& run : ExpandSweep(spec_, options_.out)) EXPECT_FALSE(FinishedRun(run).has_value());
}

TEST_F(SweepTest, BadSettingsAreFoundBeforeAnythingStarts) {
  options_.validate = [](const std::string&, const std::vector<std::string>& assignments) {
    for (const std::string& a : assignments) {
      if (a == "planner.gain=rear_side_entropy") throw core::InputError("unknown gain");
    }
  };
  EXPECT_THROW(RunSweep(spec_, options_, out_), core::InputError);
  EXPECT_EQ(Calls("car_occlusion_aware_thesis/1"), 0);
}

TEST_F(SweepTest, SlurmGetsAnArrayOfPendingRuns) {
  options_.slurm = true;
  const std::string path = getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  EXPECT_EQ(RunSweep(spec_, options_, out_), 0);
  setenv("PATH", path.c_str(), 1);
  const std::string lines = core::ReadFile(options_.out / "runs.txt");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 8);
  EXPECT_NE(lines.find(" run car --seed 1 --threads 1 --out "), std::string::npos);
  EXPECT_NE(core::ReadFile(options_.out / "sweep.sbatch").find("#SBATCH --array=1-8%4"), std::string::npos);
  EXPECT_NE(out_.str().find("sbatch is not installed here"), std::string::npos);
}

TEST(ShellQuoted, SurvivesSpacesAndQuotes) {
  EXPECT_EQ(ShellQuoted("a.b=1"), "a.b=1");
  EXPECT_EQ(ShellQuoted("it's $x"), "'it'\\''s $x'");
  EXPECT_EQ(ShellQuoted(""), "''");
}

}  // namespace
}  // namespace atlas::experiments
