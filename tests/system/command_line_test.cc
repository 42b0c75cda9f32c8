// The program as a user meets it: its answers to bad input, and a run that is interrupted.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/support/command_line.h"

namespace {

namespace fs = std::filesystem;

using atlas::tests::CommandLine;
using atlas::tests::Outcome;

TEST_F(CommandLine, UnknownNamesSuggestTheNearOne) {
  ExpectRefusal("run helicoptre", {"helicoptre", "did you mean 'helicopter'"});
  ExpectRefusal("run helicopter --set scene=cat", {"cat", "did you mean 'car'"});
  ExpectRefusal("run helicopter --set planner.gain=oclusion_aware", {"did you mean 'occlusion_aware'"});
  ExpectRefusal("run helicopter --set planner=greedi", {"did you mean 'greedy'"});
  ExpectRefusal("run helicopter --set mapper=octomop", {"did you mean 'octomap'"});
  ExpectRefusal("run helicopter --set sensors.lidar=vlp61", {"did you mean 'vlp16'"});
  ExpectRefusal("run helicopter --set robot=quadrupled", {"did you mean 'quadruped'"});
  ExpectRefusal("list scene", {"did you mean 'scenes'"});
  ExpectRefusal("runn helicopter", {"runn", "did you mean 'run'"});
}

TEST_F(CommandLine, BadValuesNameKeyValueAndLimit) {
  ExpectRefusal("run helicopter --set planner.nodes=-3", {"planner.nodes", "-3", "must be"});
  ExpectRefusal("run helicopter --set planner.nodes=many",
                {"planner.nodes", "expected a whole number", "many"});
  ExpectRefusal("run helicopter --set mapper.resolution_m=nan", {"mapper.resolution_m", "nan"});
  ExpectRefusal("run helicopter --set planner.noodles=3", {"noodles", "did you mean 'planner.nodes'"});
  ExpectRefusal("run helicopter --set nodes", {"expected section.key=value"});
  for (const char* command : {"run helicopter", "record house"}) {
    for (const char* seed : {"x", "-1", "2147483648", "99999999999999999999", "1.5", "0x10", "''"}) {
      ExpectRefusal(fmt::format("{} --seed {}", command, seed), {"--seed", seed, "0 to 2147483647"});
    }
  }
  ExpectRefusal("run helicopter --set planner=", {"--set planner=", "empty"});
  ExpectRefusal("run helicopter --threads 0", {"--threads"});
  for (const char* command :
       {"map --scans x --resolution nan", "map --scans x --max-range nan", "map --scans x --max-dt nan",
        "record house --speed nan", "record house --truth-spacing nan", "render x --speed nan",
        "sweep table_3_1 --limit nan"}) {
    ExpectRefusal(command, {"nan", "not a number from"});
  }
  ExpectRefusal("run helicopter --out ''", {"--out", "empty"});
}

TEST_F(CommandLine, BadFilesAreNamed) {
  Write("torn.yaml", "scene: [car\nplanner");
  ExpectRefusal("run torn.yaml", {"torn.yaml", "malformed YAML"});
  Write("typo.yaml", "scene: car\nplaner: greedy\n");
  ExpectRefusal("run typo.yaml", {"typo.yaml:2", "planer", "did you mean 'planner'"});
  Write("range.yaml", "extends: car\nlocomotion: {speed_mps: 40}\n");
  ExpectRefusal("run range.yaml", {"range.yaml:2", "locomotion.speed_mps", "40"});
  ExpectRefusal("run missing.yaml", {"missing.yaml", "no such file"});
  ExpectRefusal("run helicopter --set robot=nowhere/robot.xml", {"nowhere/robot.xml"});
  const std::string name = fmt::format("{:x>300}", "");
  ExpectRefusal("run helicopter --set robot=" + name + ".xml", {name});
  ExpectRefusal("run " + name, {name});
  ExpectRefusal("render " + name, {name});
  ExpectRefusal("render --plan " + name, {name});
  ExpectRefusal("run car --out " + name, {name});
  Write("blocker", "a file where a folder should be");
  ExpectRefusal("run car --out blocker/run", {"blocker/run"});
}

TEST_F(CommandLine, BadSceneFilesAreNamed) {
  const std::string head =
      "object_box: {min: [-1, -1, 0.05], max: [1, 1, 2]}\nspawn: {x: -4, y: 0, yaw_deg: 0}\nparts:\n";
  Write("no_mesh.yaml", head + "  - {name: a, mesh: none.obj, label: object, object: true}\n");
  ExpectRefusal("run helicopter --set scene=no_mesh.yaml", {"none.obj"});
  Write("empty.obj", "");
  Write("empty.yaml", head + "  - {name: a, mesh: empty.obj, label: object, object: true}\n");
  ExpectRefusal("run helicopter --set scene=empty.yaml", {"empty.obj"});
  Write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  Write("nan.yaml", head + "  - {name: a, mesh: nan.obj, label: object, object: true}\n");
  ExpectRefusal("run helicopter --set scene=nan.yaml", {"nan.obj"});
}

TEST_F(CommandLine, ListsAndExplanationsPrint) {
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"list scenes", "helicopter_grating"},
      {"list gains", "rear_side_entropy"},
      {"list mappers", "octomap"},
      {"list planners", "greedy"},
      {"list experiments", "facade_grass"},
      {"list robots", "quadruped"},
      {"list metrics", "coverage_of_attainable"},
      {"explain house", "planner.stop_ratio"}};
  for (const auto& [arguments, word] : expected) {
    const Outcome outcome = Atlas(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments;
    EXPECT_NE(outcome.text.find(word), std::string::npos) << arguments << "\n" << outcome.text;
  }
}

TEST_F(CommandLine, InterruptLeavesAValidRunFolder) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (freopen("/dev/null", "w", stderr) == nullptr || freopen("/dev/null", "w", stdout) == nullptr)
      _exit(9);
    const std::string out = (dir_ / "run").string();
    execl(atlas::tests::AtlasBinary().c_str(), "atlas", "run", "car", "--out", out.c_str(), "--set",
          "planner.nodes=20", nullptr);
    _exit(9);
  }
  const auto scanned = [&] {  // until then, nothing is kept but a summary that says `interrupted`
    std::ifstream in(dir_ / "run" / "steps.csv");
    std::stringstream steps;
    steps << in.rdbuf();
    return steps.str().find("\n1,") != std::string::npos;
  };
  for (int i = 0; i < 3000 && !scanned(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  std::ifstream in(dir_ / "run" / "summary.json");
  std::stringstream text;
  text << in.rdbuf();
  EXPECT_NE(text.str().find("\"status\": \"interrupted\""), std::string::npos) << text.str();
  for (const char* file :
       {"config.yaml", "steps.csv", "timings.csv", "candidates.csv", "coverage.svg", "cloud.ply"}) {
    EXPECT_TRUE(fs::exists(dir_ / "run" / file)) << file;
  }
}

}  // namespace
