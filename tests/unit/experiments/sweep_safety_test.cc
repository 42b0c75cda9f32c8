// A sweep whose children lie, hang, die or are given hostile names.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/results/run_folder.h"
#include "experiments/sweep/run_pool.h"
#include "experiments/sweep/slurm.h"
#include "experiments/sweep/sweep.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

// Stands in for `atlas`: notes its arguments, one a line, leaves a summary of the status that the
// experiment's name begins with, and ends as the rest of the name says.
constexpr const char* kObedientAtlas = R"sh(#!/bin/bash
experiment=$2
args=("$@")
while [ $# -gt 1 ]; do [ "$1" = --out ] && out=$2; shift; done
mkdir -p "$out"; printf '%s\n' "${args[@]}" > "$out/arguments"
case $experiment in
  deaf) trap '' INT TERM; echo $$ > "$out/pid"; while :; do sleep 0.05; done;;
  parent) sleep 300 & echo $! > "$out/pid";;
esac
status=completed; [[ $experiment = robot_fell* ]] && status=robot_fell
echo "planner.nodes: 1" > "$out/config.yaml"
printf '{"experiment":"x","seed":1,"status":"%s","stop_reason":"explored","coverage":0.7}' $status \
  > "$out/summary.json"
case $experiment in
  *_exit_*) exit ${experiment##*_exit_};;
  *_killed) kill -9 $$;;
esac
exit 0
)sh";

class SweepSafety : public ::testing::Test {
 protected:
  SweepSafety() {
    root_ = fs::temp_directory_path() / ("atlas_sweep_safety_" + std::to_string(getpid()) + "_" +
                                         ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    core::WriteFileAtomically(root_ / "atlas", kObedientAtlas);
    chmod((root_ / "atlas").c_str(), 0755);
    options_.identify = [](const std::string&, const std::vector<std::string>&) { return RunIdentity(); };
    options_.executable = root_ / "atlas";
    options_.out = root_ / "out";
    options_.jobs = 4;
    options_.interrupt_grace_s = options_.terminate_grace_s = 0.2;
    spec_.name = "test";
    spec_.seeds = {1};
  }
  ~SweepSafety() override { fs::remove_all(root_); }

  int Run(const std::vector<std::string>& experiments) {
    spec_.experiments = experiments;
    out_.str("");
    return RunSweep(spec_, options_, out_);
  }
  RunStatus StatusIn(const std::string& experiment) const {
    return LoadRunSummary(options_.out / experiment / "1").status;
  }
  bool Lives(const std::string& experiment) const {
    const int pid = std::stoi(core::ReadFile(options_.out / experiment / "1" / "pid"));
    std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
    std::string number, name, state;
    return in >> number >> name >> state && state != "Z";  // or waits for its parent only
  }
  std::string ErrorOf(const std::string& yaml) const {
    core::WriteFileAtomically(root_ / "spec.yaml", yaml);
    try {
      LoadSweep((root_ / "spec.yaml").string());
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

TEST_F(SweepSafety, AChildThatEndsOtherwiseThanItsSummarySaysHasFailed) {
  const std::vector<std::string> liars = {"completed_exit_1", "completed_exit_2", "completed_killed",
                                          "robot_fell_exit_0", "robot_fell_exit_2"};
  std::vector<std::string> all = liars;
  all.insert(all.end(), {"completed", "robot_fell_exit_1"});
  EXPECT_EQ(Run(all), 1);
  for (const std::string& liar : liars) {
    EXPECT_EQ(StatusIn(liar), RunStatus::kFailed) << liar;
    EXPECT_NE(out_.str().find(liar + "/1: no result"), std::string::npos) << out_.str();
  }
  EXPECT_EQ(StatusIn("completed"), RunStatus::kCompleted);
  EXPECT_EQ(StatusIn("robot_fell_exit_1"), RunStatus::kRobotFell);
  EXPECT_EQ(Run(all), 1);  // failed is not final: those alone run again
  EXPECT_NE(out_.str().find("7 runs: 2 done, 5 broken"), std::string::npos) << out_.str();
}

TEST_F(SweepSafety, WhatIsRunAgainFindsABrokenRunInItsFolder) {
  core::WriteFileAtomically(
      root_ / "atlas",
      std::string(kObedientAtlas)
          .replace(0, 12, "#!/bin/bash\ncp \"${@: -1}/summary.json\" \"${@: -1}/found\" 2>&-\n"));
  chmod((root_ / "atlas").c_str(), 0755);
  const fs::path folder = options_.out / "completed/1";
  Run({"completed"});
  EXPECT_FALSE(fs::exists(folder / "found")) << "nothing was there";
  for (const char* left :
       {R"({"experiment": "x", "seed": 2, "status": "completed", "stop_reason": "explored"})",
        R"({"experiment": "x", "se)", ""}) {
    core::WriteFileAtomically(folder / "summary.json", left);
    if (std::string(left).empty()) fs::remove(folder / "summary.json");
    fs::remove(folder / "found");
    Run({"completed"});
    const RunSummary found = SummaryFromJson(core::ReadFile(folder / "found"), left);
    EXPECT_EQ(found.status, RunStatus::kInterrupted) << left;
    EXPECT_EQ(StatusIn("completed"), RunStatus::kCompleted);
  }
}

TEST_F(SweepSafety, AFolderOfTheUsersIsNotTakenForARun) {
  core::WriteFileAtomically(options_.out / "deaf/1/config.yaml", "mine");
  spec_.limit_s = 0.3;
  Run({"deaf"});
  EXPECT_FALSE(fs::exists(options_.out / "deaf/1/summary.json"));
}

TEST_F(SweepSafety, ASummaryOfTheUsersIsNotTakenForALeftover) {
  SweepRun run;
  run.experiment = "car";
  run.folder = options_.out / "car/1";
  core::WriteFileAtomically(run.folder / "summary.json", "{\"mine\": 1}");
  ClaimLeftovers(run);
  EXPECT_EQ(core::ReadFile(run.folder / "summary.json"), "{\"mine\": 1}");
  core::WriteFileAtomically(run.folder / "console.log", "");
  ClaimLeftovers(run);
  EXPECT_TRUE(HoldsRun(run.folder)) << "what a sweep's child left";
}

TEST_F(SweepSafety, AChildThatStopsAnsweringMeetsTheLimit) {
  spec_.limit_s = 0.4;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(Run({"deaf", "completed"}), 1);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  EXPECT_NE(out_.str().find("FAILED (no end within 0.4 s)"), std::string::npos) << out_.str();
  EXPECT_FALSE(Lives("deaf"));
  EXPECT_EQ(StatusIn("completed"), RunStatus::kCompleted);
}

TEST_F(SweepSafety, TheLimitIsTheSpecsOrFollowsItsEstimate) {
  EXPECT_EQ(LimitOf({}), 3600.0);
  spec_.estimate_s = 1000.0;
  EXPECT_EQ(LimitOf(spec_), 10000.0);
  spec_.limit_s = 7.0;
  EXPECT_EQ(LimitOf(spec_), 7.0);
  EXPECT_EQ(ErrorOf("experiments: [car]\nseeds: 1\nlimit_s: 30\n"), "");
  EXPECT_NE(ErrorOf("experiments: [car]\nseeds: 1\nlimit_s: 0\n").find("spec.yaml:3: limit_s"),
            std::string::npos);
}

TEST_F(SweepSafety, WhatAChildStartedEndsWithIt) {
  EXPECT_EQ(Run({"parent"}), 0);
  for (int i = 0; i < 50 && Lives("parent"); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(Lives("parent"));
}

TEST_F(SweepSafety, StoppingEndsEvenTheDeaf) {
  bool started = false;
  options_.should_stop = [&] {
    started = started || fs::exists(options_.out / "deaf/1/pid");
    return started;
  };
  EXPECT_EQ(Run({"deaf"}), 130);
  EXPECT_FALSE(Lives("deaf"));
}

TEST_F(SweepSafety, TheLogOfAChildFollowsNoLink) {
  core::WriteFileAtomically(root_ / "victim", "untouched");
  fs::create_directories(options_.out / "completed/1");
  fs::create_symlink(root_ / "victim", options_.out / "completed/1/console.log");
  EXPECT_EQ(Run({"completed"}), 0);
  EXPECT_EQ(core::ReadFile(root_ / "victim"), "untouched");
}

TEST_F(SweepSafety, EscapesInTheOutputOfAChildAreShown) {
  core::WriteFileAtomically(root_ / "atlas", "#!/bin/bash\nprintf 'bad \\033[2J\\n'; exit 3\n");
  chmod((root_ / "atlas").c_str(), 0755);
  EXPECT_EQ(Run({"car"}), 1);
  EXPECT_NE(out_.str().find("FAILED (exit code 3): bad \\x1b[2J\n"), std::string::npos) << out_.str();
}

TEST_F(SweepSafety, ControlCharactersAreRefusedWhereASpecIsRead) {
  const std::string good = "experiments: [car]\nseeds: 1\n";
  EXPECT_EQ(ErrorOf(good + "doc: |\n  two\n  lines\n"), "");
  EXPECT_NE(ErrorOf(good + "set: [\"a=b\\ntouch x\"]\n").find("spec.yaml:3: set: holds a control character"),
            std::string::npos);
  EXPECT_NE(ErrorOf("seeds: 1\nexperiments: [\"c\\e[2Jar\"]\n").find("'c\\x1b[2Jar'"), std::string::npos);
  EXPECT_NE(ErrorOf(good + "grid: {\"a\\tb\": [1]}\n").find("spec.yaml:3: grid"), std::string::npos);
  EXPECT_NE(ErrorOf(good + "grid: {a: [\"1\\n2\"]}\n").find("spec.yaml:3: grid.a"), std::string::npos);
}

TEST_F(SweepSafety, AKeyThatStandsTwiceIsRefused) {
  const std::string good = "experiments: [car]\nseeds: 1\n", file = (root_ / "spec.yaml").string();
  EXPECT_EQ(ErrorOf(good + "grid: {planner.nodes: [10, 20], planner.nodes: [30]}\n"),
            file + ":3: the key 'planner.nodes' stands twice (first in line 3)");
  EXPECT_EQ(ErrorOf(good + "seeds: 2\n"), file + ":3: the key 'seeds' stands twice (first in line 2)");
  EXPECT_EQ(ErrorOf(good + "---\nseeds: 2\n"), file + ":3: a second document (a file holds one)");
  EXPECT_EQ(ErrorOf(good + "grid: &a {b: *a}\n"), file + ":3: an alias stands inside of what it names");
}

TEST_F(SweepSafety, WhatAnExperimentRefusesIsToldByTheSweepsFileAndField) {
  const std::string good = "experiments: [car]\nseeds: 1\n", file = (root_ / "spec.yaml").string();
  options_.identify = [](const std::string& experiment, const std::vector<std::string>& assignments) {
    return IdentityOf(LoadExperiment(experiment, assignments));
  };
  const auto refusal = [&](const std::string& yaml) -> std::string {
    core::WriteFileAtomically(root_ / "spec.yaml", yaml);
    try {
      IdentifiedRuns(LoadSweep(file), options_, root_ / "out");
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string told = "unknown key 'planner.nodez'; did you mean 'planner.nodes'?";
  EXPECT_EQ(refusal(good + "grid:\n  planner.nodez: [1]\n"), file + ":4: grid: planner.nodez=1: " + told);
  EXPECT_EQ(refusal(good + "set: [planner.nodez=1]\n"), file + ":3: set: planner.nodez=1: " + told);
  EXPECT_EQ(refusal(good + "variants: {a: [planner.nodez=1]}\n"),
            file + ":3: variants.a: planner.nodez=1: " + told);
  EXPECT_EQ(refusal(good + "set: [planner=]\n"), file + ":3: set: planner=: the value is empty");
  EXPECT_TRUE(refusal("experiments: [carr]\nseeds: 1\n").starts_with(file + ": carr: unknown experiment"));
}

TEST_F(SweepSafety, ControlCharactersInASettingStartNothing) {
  spec_.set = {"mission.max_scans=5\ntouch pwned"};
  for (const bool slurm : {false, true}) {
    options_.slurm = slurm;
    EXPECT_THROW(Run({"completed"}), core::InputError);
    EXPECT_FALSE(fs::exists(options_.out / "completed/1/arguments"));
    EXPECT_FALSE(fs::exists(options_.out / "runs.txt"));
  }
}

class SlurmScript : public SweepSafety {
 protected:
  /// Writes the script where there is no sbatch, then runs one task of it.
  int RunTask(const std::vector<std::string>& experiments, int task) {
    options_.slurm = true;
    const std::string path = getenv("PATH");
    setenv("PATH", "/nonexistent", 1);
    EXPECT_EQ(Run(experiments), 0);
    setenv("PATH", path.c_str(), 1);
    options_.slurm = false;
    const std::string command = "cd / && SLURM_ARRAY_TASK_ID=" + std::to_string(task) + " bash " +
                                core::ShellQuoted((options_.out / "sweep.sbatch").string());
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(SlurmScript, PassesHostileNamesOnAsTheyAre) {
  options_.out = root_ / "out 'a' \"b\" $(touch pwned) ; touch pwned & * \\";
  spec_.name = "x --wrap=evil";
  spec_.set = {"scene=it's $(touch pwned); `touch pwned`", "a.b=c d"};
  EXPECT_EQ(RunTask({"completed"}, 1), 0);
  const std::string arguments = core::ReadFile(options_.out / "completed/1/arguments");
  EXPECT_NE(arguments.find("\n--set\nscene=it's $(touch pwned); `touch pwned`\n--set\na.b=c d\n"),
            std::string::npos)
      << arguments;
  for (const fs::path& folder : {root_, fs::path("/"), fs::current_path(), options_.out}) {
    EXPECT_FALSE(fs::exists(folder / "pwned")) << folder;
  }
  const std::string script = core::ReadFile(options_.out / "sweep.sbatch");
  EXPECT_EQ(script.find(" --wrap"), std::string::npos) << script;
  EXPECT_NE(script.find("#SBATCH --time=60\n"), std::string::npos) << script;
}

TEST_F(SlurmScript, ATaskThatEndsOtherwiseThanItsSummarySaysDoesNotCount) {
  RunTask({"completed_exit_3", "completed"}, 1);
  RunTask({"completed_exit_3", "completed"}, 2);
  for (const SweepRun& run : IdentifiedRuns(spec_, options_, options_.out)) {
    EXPECT_EQ(FinishedRun(run, options_).has_value(), run.experiment == "completed") << run.experiment;
  }
}

TEST(ShellQuoted, KeepsEveryByteOnOneLine) {
  std::string all;
  for (int c = 1; c < 256; ++c) all += static_cast<char>(c);
  const std::string quoted = core::ShellQuoted(all);
  EXPECT_EQ(quoted.find('\n'), std::string::npos);
  const fs::path script = fs::temp_directory_path() / ("atlas_quoted_" + std::to_string(getpid()));
  core::WriteFileAtomically(
      script, "printf %s " + quoted + " > " + core::ShellQuoted(script.string() + ".out") + "\n");
  ASSERT_EQ(std::system(("bash " + script.string()).c_str()), 0);
  EXPECT_EQ(core::ReadFile(script.string() + ".out"), all);
  fs::remove(script);
  fs::remove(script.string() + ".out");
}

}  // namespace
}  // namespace atlas::experiments
