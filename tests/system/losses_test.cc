// What may never be lost: a run, a sweep or a map that a signal, a limit or a full disk ends.
#include <fcntl.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "tests/support/child.h"
#include "tests/support/command_line.h"

namespace {

namespace fs = std::filesystem;
using atlas::core::ReadFile;
using atlas::tests::Child;
using atlas::tests::ChildOptions;
using atlas::tests::Eventually;

class Losses : public atlas::tests::CommandLine {
 protected:
  /// A mission of seconds on a coarse truth.
  std::vector<std::string> ShortRun(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {atlas::tests::AtlasBinary().string(), "run", "car", "--out", "run"};
    std::vector<std::string> sets = {"mission.truth_spacing_m=0.1", "mission.max_scans=2", "planner.nodes=20",
                                     "locomotion=kinematic"};
    sets.insert(sets.end(), more.begin(), more.end());
    for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
    return arguments;
  }
  /// One whose preparation takes minutes, for nothing is cached.
  std::vector<std::string> LongPreparation() const {
    return {atlas::tests::AtlasBinary().string(), "run", "house", "--out", "run", "--threads", "1"};
  }
  ChildOptions Options() const {
    return {.folder = dir_,
            .error = dir_ / "stderr",
            .environment = {{"ATLAS_CACHE", (dir_ / "cache").string()}}};
  }
  nlohmann::json Summary(const std::string& folder = "run") const {
    return nlohmann::json::parse(ReadFile(dir_ / folder / "summary.json"));
  }
  bool Exists(const std::string& name) const { return fs::exists(dir_ / name); }
};

TEST_F(Losses, EachSignalEndsPreparationWithinASecond) {
  for (const int number : {SIGTERM, SIGHUP, SIGINT, SIGPIPE}) {
    SCOPED_TRACE(strsignal(number));
    fs::remove_all(dir_ / "run");
    Child run(LongPreparation(), Options());
    ASSERT_TRUE(Eventually([&] { return Exists("run/summary.json"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    run.Signal(number);
    EXPECT_EQ(run.Wait(1.0), 130);
    EXPECT_EQ(Summary()["status"], "interrupted");
  }
}

// SIGHUP comes from the shell and from the kernel when a terminal closes: twice is no reason to lose the
// summary.
TEST_F(Losses, AClosedTerminalEndsARunWithItsSummary) {
  Child run(ShortRun(), Options());
  ASSERT_TRUE(Eventually([&] {
    return Exists("run/steps.csv") && ReadFile(dir_ / "run/steps.csv").find("\n1,") != std::string::npos;
  }));
  run.Signal(SIGHUP);
  run.Signal(SIGHUP);
  EXPECT_EQ(run.Wait(), 130);
  EXPECT_EQ(Summary()["status"], "interrupted");
  EXPECT_GE(Summary()["scans"], 1);
  for (const char* file : {"run/cloud.ply", "run/map.atlas", "run/log.txt"})
    EXPECT_TRUE(Exists(file)) << file;
}

TEST_F(Losses, AClosedPipeEndsARunWithItsSummary) {
  ASSERT_EQ(mkfifo((dir_ / "pipe").c_str(), 0600), 0);
  const int reader = open((dir_ / "pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ChildOptions options = Options();
  options.error = dir_ / "pipe";
  Child run(ShortRun({"mission.max_scans=30"}), options);
  ASSERT_TRUE(Eventually([&] { return Exists("run/ground_truth.ply"); }));
  close(reader);  // the next line meets nobody
  EXPECT_EQ(run.Wait(), 130);
  EXPECT_EQ(Summary()["status"], "interrupted");
}

TEST_F(Losses, AFileThatDoesNotFitFailsTheRunAndSaysSo) {
  ChildOptions options = Options();
  options.largest_file = 30000;  // summary.json fits, ground_truth.ply does not
  Child run(ShortRun(), options);
  EXPECT_EQ(run.Wait(), 2);
  EXPECT_EQ(Summary()["status"], "failed");
  EXPECT_NE(ReadFile(dir_ / "stderr").find("cannot write (File too large)"), std::string::npos)
      << ReadFile(dir_ / "stderr");
}

TEST_F(Losses, ASweepEndsWithItsChildrenWhateverEndsIt) {
  Write("spec.yaml", "experiments: [house]\nseeds: 1\n");
  const auto orphans = [&] {  // processes that name this test's folder
    size_t count = 0;
    std::error_code error;
    for (const auto& process : fs::directory_iterator("/proc")) {
      std::ifstream in(process.path() / "cmdline", std::ios::binary);
      const std::string line{std::istreambuf_iterator<char>(in), {}};
      count += line.find((dir_ / "out").string()) != std::string::npos;
    }
    return count;
  };
  for (const int number : {SIGHUP, SIGTERM, SIGKILL}) {
    SCOPED_TRACE(strsignal(number));
    fs::remove_all(dir_ / "out");
    Child sweep(
        {atlas::tests::AtlasBinary().string(), "sweep", "spec.yaml", "--out", (dir_ / "out").string()},
        Options());
    ASSERT_TRUE(Eventually([&] { return Exists("out/house/1/summary.json"); }));
    EXPECT_EQ(orphans(), 2u);
    sweep.Signal(number);
    EXPECT_EQ(sweep.Wait(5.0), number == SIGKILL ? -SIGKILL : 130);
    EXPECT_TRUE(Eventually([&] { return orphans() == 0; }, 2.0)) << orphans();
    EXPECT_EQ(Summary("out/house/1")["status"], "interrupted");
  }
}

TEST_F(Losses, WhatAKilledRunLeftIsSweptUpByTheNext) {
  const std::string stale = "run/map.atlas.tmp999999999-0123456789abcdef";
  fs::create_directories(dir_ / "run");
  Write(stale, "");
  Write("run/notes.tmp1", "mine");
  Child run(LongPreparation(), Options());
  ASSERT_TRUE(Eventually([&] { return Exists("run/summary.json"); }));
  EXPECT_FALSE(Exists(stale));
  EXPECT_TRUE(Exists("run/notes.tmp1"));
}

TEST_F(Losses, ACameraThatCannotStartIsSaidFirstAndInTheSummary) {
  for (const char* library : {"libEGL.so.1", "libEGL.so", "libOSMesa.so.8", "libOSMesa.so"})
    Write(library, "");
  ChildOptions options = Options();
  options.environment.emplace_back("LD_LIBRARY_PATH", dir_.string());
  Child run(ShortRun({"mission.max_scans=1"}), options);
  EXPECT_EQ(run.Wait(), 0);
  const std::string said = ReadFile(dir_ / "stderr");
  EXPECT_TRUE(said.starts_with("no depth camera: ")) << said;
  EXPECT_EQ(Summary()["render_backend"], "none");
  EXPECT_NE(said.find(Summary()["render_problem"]), std::string::npos);
  EXPECT_TRUE(ReadFile(dir_ / "run/log.txt").starts_with("no depth camera: "));
  Child explain({atlas::tests::AtlasBinary().string(), "explain", "car"}, options);
  EXPECT_EQ(explain.Wait(), 0);
  EXPECT_NE(ReadFile(dir_ / "stderr").find("sensors.depth_camera: cannot start on this machine"),
            std::string::npos);
}

TEST_F(Losses, AVideoThatIsKilledFailsTheRunAndKeepsTheRest) {
  fs::create_directories(dir_ / "bin");
  Write("bin/ffmpeg",
        "#!/bin/bash\nfor word; do [ \"$word\" = -version ] && exit 0; done\nhead -c 100000 >/dev/null\nkill "
        "-9 $$\n");
  fs::permissions(dir_ / "bin/ffmpeg", fs::perms::owner_all);
  ChildOptions options = Options();
  options.environment.emplace_back("PATH", (dir_ / "bin").string() + ":" + getenv("PATH"));
  Child run(ShortRun({"mission.max_scans=1", "output.video=true"}), options);
  EXPECT_EQ(run.Wait(), 2);
  EXPECT_EQ(Summary()["status"], "failed");
  EXPECT_NE(ReadFile(dir_ / "stderr").find("video: ffmpeg failed"), std::string::npos)
      << ReadFile(dir_ / "stderr");
  for (const char* file : {"run/cloud.ply", "run/map.atlas", "run/steps.csv"})
    EXPECT_TRUE(Exists(file)) << file;
}

TEST_F(Losses, OutputThatNobodyTakesIsAnError) {
  EXPECT_EQ(Atlas("list gains > /dev/full").exit_code, 1);
  EXPECT_EQ(Atlas("list gains").exit_code, 0);
}

}  // namespace
