#include "experiments/sweep/sweep.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "experiments/sweep/slurm.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

// Stands in for `atlas`: counts its calls, writes a summary, or misbehaves when the experiment says so. The
// files `nodes` and `commit` beside it stand for an experiment's YAML and for the program's commit.
constexpr const char* kFakeAtlas = R"sh(#!/bin/bash
shift; experiment=$1; shift
gain=none; planner=none
sets=; config=
while [ $# -gt 0 ]; do
  case $1 in
    --force) shift; continue;;
    --seed) seed=$2;;
    --out) out=$2;;
    --set) case $2 in planner.gain=*) gain=${2#*=};; planner.name=*) planner=${2#*=};; esac
           sets="$sets $2"; config="$config${2%%=*}: ${2#*=}\n";;
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
nodes=$(cat "$(dirname "$0")/nodes"); commit=$(cat "$(dirname "$0")/commit")
printf "planner.nodes: $nodes\nscene.name: x\nrobot.name: x\n$config" > "$out/config.yaml"
printf '{"experiment":"%s","config_hash":"%s","commit":"%s","gain":"%s","planner":"%s","seed":%d,"status":"%s","stop_reason":"explored",
"coverage":0.%d,"scans":9,"travel_distance_m":30,"sim_time_s":500,"wall_time_s":4.5,"falls":0,"collisions":0}' \
  "$experiment" "$experiment $nodes$sets" "$commit" "$gain" "$planner" "$seed" "$status" "$((70 + seed))" > "$out/summary.json"
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
    Write("nodes", "150");
    Write("commit", "abc");
    options_.identify = [this](const std::string& experiment, const std::vector<std::string>& assignments) {
      const std::string nodes = core::ReadFile(root_ / "nodes");
      RunIdentity identity{.settings = {{"planner.nodes", nodes}, {"scene.name", ""}, {"robot.name", ""}},
                           .config_hash = experiment + " " + nodes,
                           .commit = core::ReadFile(root_ / "commit")};
      for (const std::string& assignment : assignments) {
        identity.config_hash += " " + assignment;
        const size_t equals = assignment.find('=');
        identity.settings[assignment.substr(0, equals)] = assignment.substr(equals + 1);
      }
      return identity;
    };
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

  void Write(const std::string& name, const std::string& text) const {
    core::WriteFileAtomically(root_ / name, text);
  }
  /// What the sweep says when it is started once more.
  std::string Again() {
    std::ostringstream again;
    RunSweep(spec_, options_, again);
    return again.str();
  }
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
}

TEST_F(SweepTest, EveryVaryingSettingIsPartOfTheFoldersName) {
  spec_.grid = {{"mapper.resolution_m", {"0.05", "0.1"}}};
  const std::vector<SweepRun> runs = ExpandSweep(spec_, "out");
  ASSERT_EQ(runs.size(), 4u);
  EXPECT_EQ(runs[2].folder, fs::path("out/car_0.1/1"));
}

TEST_F(SweepTest, VariantsAreSettingsThatGoTogetherUnderAName) {
  const SweepSpec spec = LoadSweep(WriteSpec(
      "experiments: [car]\ngrid: {planner.gain: [occlusion_aware, rear_side_entropy]}\n"
      "variants: {thesis: [planner=thesis], atlas: [planner=thesis, mapper=se_atlas]}\nseeds: [7, 9]\n"));
  const std::vector<SweepRun> runs = ExpandSweep(spec, "out");
  ASSERT_EQ(runs.size(), 2u * 2u * 2u);
  EXPECT_EQ(runs[0].folder, fs::path("out/car_occlusion_aware_thesis/7"));
  EXPECT_EQ(runs[7].folder, fs::path("out/car_rear_side_entropy_atlas/9"));
  EXPECT_EQ(runs[7].assignments, (std::vector<std::string>{"planner.gain=rear_side_entropy", "planner=thesis",
                                                           "mapper=se_atlas"}));
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 1\nvariants: {a: [planner]}\n")
                .find("spec.yaml:3: variants.a: expected a.b=value, found 'planner'"),
            std::string::npos);
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 1\nvariants: [a]\n").find("spec.yaml:3: variants"),
            std::string::npos);
}

/// The seeds that parameters were tuned on are 1 to 10: tables do not use them.
TEST_F(SweepTest, TablesUseOtherSeedsThanThoseThatParametersWereTunedOn) {
  for (const char* name : {"table_3_1", "table_3_1_greedy", "table_3_2", "mappers"}) {
    const SweepSpec spec = LoadSweep(name);
    EXPECT_GE(spec.seeds.size(), 5u) << name;
    for (const uint64_t seed : spec.seeds) EXPECT_GT(seed, 10u) << name;
  }
}

TEST_F(SweepTest, TheSweepsOfTheThesisLoad) {
  const SweepSpec one = LoadSweep("table_3_1");
  EXPECT_EQ(ExpandSweep(one, "x").size(), 4u * 2u * 3u * 5u);
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
  for (const char* place : {"set: [seed=3]", "grid: {seed: [3, 4]}", "variants: {a: [seed=3]}"}) {
    EXPECT_NE(ErrorOf(std::string("experiments: [car]\nseeds: 1\n") + place).find("stand under 'seeds'"),
              std::string::npos);
  }
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
  EXPECT_NE(out_.str().find("8 runs: 8 new; 8 to run, 4 at a time; estimated time 04:00"), std::string::npos);
  EXPECT_NE(out_.str().find("71.50 [71.00, 72.00]"), std::string::npos);
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
  EXPECT_NE(again.str().find("8 runs: 6 done, 1 broken (interrupted), 1 new; 2 to run"), std::string::npos)
      << again.str();
  EXPECT_NE(again.str().find("from finished runs"), std::string::npos);
}

TEST_F(SweepTest, ChangedSettingsAreRunAgain) {
  RunSweep(spec_, options_, out_);
  spec_.set = {"mission.max_scans=5"};
  const std::string again = Again();
  EXPECT_NE(again.find("8 stale (mission.max_scans changed); 8 to run"), std::string::npos) << again;
}

TEST_F(SweepTest, AnEditedExperimentIsStaleAndRunsOnce) {
  spec_.grid.clear();
  RunSweep(spec_, options_, out_);
  Write("nodes", "20");
  const std::string again = Again();
  EXPECT_NE(again.find("2 runs: 2 stale (planner.nodes changed); 2 to run"), std::string::npos) << again;
  EXPECT_EQ(Calls("car/1"), 2);
  EXPECT_NE(Again().find("2 runs: 2 done; 0 to run"), std::string::npos);
  EXPECT_EQ(Calls("car/1"), 2);
}

TEST_F(SweepTest, AnotherCommitIsStale) {
  spec_.grid.clear();
  RunSweep(spec_, options_, out_);
  spec_.seeds = {1, 2, 3};
  Write("commit", "abc+1234");
  const std::string again = Again();
  EXPECT_NE(again.find("2 stale (commit abc, now abc+1234), 1 new; 3 to run"), std::string::npos) << again;
  EXPECT_EQ(Calls("car/1"), 2);
}

TEST_F(SweepTest, StaleResultsAreKeptWhereTheUserSaysSo) {
  spec_.grid.clear();
  RunSweep(spec_, options_, out_);
  Write("nodes", "20");
  spec_.seeds = {1, 2, 3};
  options_.keep_stale = true;
  const std::string again = Again();
  EXPECT_NE(again.find("2 stale (planner.nodes changed), 1 new, stale ones kept; 1 to run"),
            std::string::npos)
      << again;
  EXPECT_EQ(Calls("car/1"), 1);
  EXPECT_NE(again.find("planner.nodes=150"), std::string::npos) << again;  // two rows, told apart
  EXPECT_NE(again.find("planner.nodes=20"), std::string::npos);
}

TEST_F(SweepTest, AConfigurationThatChangesMeanwhileIsNoResult) {
  spec_.grid.clear();
  spec_.seeds = {1};
  core::WriteFileAtomically(root_ / "atlas",
                            std::string(kFakeAtlas).insert(12, "echo 7 > $(dirname $0)/nodes\n"));
  chmod((root_ / "atlas").c_str(), 0755);
  EXPECT_EQ(RunSweep(spec_, options_, out_), 1);
  EXPECT_NE(out_.str().find("car/1: no result, planner.nodes changed"), std::string::npos) << out_.str();
}

TEST_F(SweepTest, FilesOfASweepAreRelativeToIt) {
  Write("mine/s.yaml",
        "experiments: [walk.yaml, car]\nseeds: 1\ngrid: {scene: [../a.yaml, house]}\nset: [robot=dog.xml]\n");
  const SweepSpec spec = LoadSweep((root_ / "mine/s.yaml").string());
  EXPECT_EQ(spec.experiments, (std::vector<std::string>{(root_ / "mine/walk.yaml").string(), "car"}));
  EXPECT_EQ(spec.grid[0].second, (std::vector<std::string>{(root_ / "a.yaml").string(), "house"}));
  EXPECT_EQ(spec.set, (std::vector<std::string>{"robot=" + (root_ / "mine/dog.xml").string()}));
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
  for (const SweepRun& run : IdentifiedRuns(spec_, options_, options_.out)) {
    EXPECT_FALSE(FinishedRun(run, options_).has_value());
  }
}

TEST_F(SweepTest, BadSettingsAreFoundBeforeAnythingStarts) {
  options_.identify = [](const std::string&, const std::vector<std::string>& assignments) {
    for (const std::string& a : assignments) {
      if (a == "planner.gain=rear_side_entropy") throw core::InputError("unknown gain");
    }
    return RunIdentity{};
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
  EXPECT_NE(lines.find(" run car --seed 1 --threads 1 --force --out "), std::string::npos);
  EXPECT_NE(core::ReadFile(options_.out / "sweep.sbatch").find("#SBATCH --array=1-8%4"), std::string::npos);
  EXPECT_NE(out_.str().find("sbatch is not installed here"), std::string::npos);
}

TEST(ShellQuoted, SurvivesSpacesAndQuotes) {
  EXPECT_EQ(core::ShellQuoted("a.b=1"), "a.b=1");
  EXPECT_EQ(core::ShellQuoted("it's $x"), "'it'\\''s $x'");
  EXPECT_EQ(core::ShellQuoted(""), "''");
}

}  // namespace
}  // namespace atlas::experiments
