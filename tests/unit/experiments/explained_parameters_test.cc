// Every parameter that `atlas explain` prints does something: changed alone, it changes what a mission leaves
// behind. What the simulator, the mapper, the elevation map and the planner are given is changed under each
// of them by itself, which takes a tenth of the time (explained_parts_test.cc); here that the mission gives
// it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/explained_rows.h"
#include "tests/support/tiny_mission.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using tests::ParameterProbe;
using tests::Settings;

/// Two scans 0.4 m apart.
const std::vector<std::string> kMission = {
    "planner=route", "planner.route=[-1.8 0, -1.8 0.4 90, -1.8 0.8 90]", "planner.terrain.window_m=5"};

/// What a mission leaves behind, but for what the machine's speed decides.
std::string Remains(const fs::path& folder) {
  std::map<std::string, std::string> remains;
  const std::set<std::string> kinds = {".tum", ".ply", ".atlas", ".bt", ".pgm", ".mp4", ".csv"};
  for (const auto& file : fs::directory_iterator(folder)) {
    if (kinds.count(file.path().extension()) == 0 || file.path().stem() == "timings") continue;
    remains[file.path().filename()] = core::ReadFile(file.path());
  }
  const auto summary = nlohmann::json::parse(core::ReadFile(folder / "summary.json"));
  for (const char* key : {"experiment", "status", "stop_reason", "coverage", "coverage_attainable",
                          "coverage_of_attainable", "cloud_error_m_mean", "sim_time_s", "scans"}) {
    if (summary.contains(key)) remains[key] = summary[key].dump();
  }
  tests::Digest digest;
  for (const auto& [name, text] : remains) digest.Add(name + text);
  return digest.text();
}

class ExplainedParameters : public ::testing::Test {
 protected:
  ExplainedParameters()
      : probe_([this](const std::vector<std::string>& set) { return missions_.LoadBare(set); },
               [this](const ExperimentConfig& config) { return Run(config); }) {}

  std::string Run(const ExperimentConfig& config) const {
    RunOptions options;
    options.folder = missions_.folder() / "run";
    RunClosedLoop(config, options);
    const std::string remains = Remains(options.folder);
    fs::remove_all(options.folder);
    return remains;
  }

  tests::TinyMissions missions_;
  ParameterProbe probe_;
};

TEST_F(ExplainedParameters, OfTheMissionAct) {
  const Settings settings = {
      {"mission.max_scans", {{}, "1"}},
      {"mission.max_time_s", {{}, "2"}},
      {"mission.max_distance_m",
       {{"mission.max_scans=3", "planner.route=[-1.8 0, -1.8 1.2 90, -1.8 1.6 90]"}, "1"}},
      {"mission.flat_coverage", {{"mission.flat_scans=1", "mission.flat_coverage=1"}, "0"}},
      {"mission.plan_after", {{}, "", "MapGround"}},
      {"mission.flat_scans", {{"mission.flat_scans=1", "mission.flat_coverage=1"}, "2"}},
  };
  probe_.SeeNothingElseAct(kMission);
  probe_.SeeThemAct("mission", kMission, settings);
}

TEST_F(ExplainedParameters, OfTheOutputAct) {
  const std::vector<std::string> fast = {"mission.max_scans=1", "output.video_speed=100"};
  const Settings settings = {{"output.video", {fast}},
                             {"output.video_speed", {{fast[0], fast[1], "output.video=true"}, "40"}}};
  probe_.SeeThemAct("output", kMission, settings);
}

TEST_F(ExplainedParameters, NamesAct) {
  const std::string block = core::ReadFile(missions_.folder() / "block.yaml");
  core::WriteFileAtomically(missions_.folder() / "lower.yaml",
                            std::string(block).replace(block.find("0.6, 0.9"), 8, "0.6, 0.5"));
  std::string robot = core::ReadFile(core::InstalledFile("robots/quadruped.xml"));
  const std::string lidar = R"(<site name="lidar" pos="0 0 0.25"/>)";
  ASSERT_NE(robot.find(lidar), std::string::npos);
  core::WriteFileAtomically(
      missions_.folder() / "taller.xml",
      robot.replace(robot.find(lidar), lidar.size(), R"(<site name="lidar" pos="0 0 0.30"/>)"));
  std::vector<std::string> short_mission = kMission;
  short_mission.emplace_back("mission.max_scans=1");
  const std::string folder = missions_.folder().string() + "/";
  EXPECT_EQ(probe_.SeeThemAct("", short_mission, {{"experiment", {{}, "another"}}, {"seed", {{}, "4"}}}), 2);
  EXPECT_EQ(probe_.SeeThemAct("scene", short_mission, {{"scene.name", {{}, folder + "lower.yaml"}}}), 1);
  EXPECT_EQ(probe_.SeeThemAct("robot", short_mission, {{"robot.name", {{}, folder + "taller.xml"}}}), 1);
}

TEST_F(ExplainedParameters, EverySectionReachesTheMission) {
  const std::vector<std::pair<std::string, std::string>> one_of_each = {
      {"locomotion.sweep_roll_deg", "20"},  {"odometry.drift_xy_per_m", "0.1"},
      {"localisation.sigma_m", "0.05"},     {"sensors.range_sigma_m", "0.05"},
      {"mapper.resolution_m", "0.2"},       {"planner.route", "[-1.8 0, -1.8 0.3 80]"},
      {"planner.terrain.max_fill_m", "0.1"}};
  std::set<std::string> probed = {"", "scene", "robot", "mission", "output"}, sections;
  for (const auto& [path, value] : one_of_each) {
    const std::string section = path.substr(0, path.rfind('.'));
    const bool walks = section == "odometry" || section == "planner";
    probe_.SeeItAct(path, kMission, {{walks ? "mission.max_scans=2" : "mission.max_scans=1"}, value});
    probed.insert(section);
  }
  for (const core::ParamRow& row : missions_.LoadBare({}).rows) {
    const size_t dot = row.path.rfind('.');
    sections.insert(dot == std::string::npos ? "" : row.path.substr(0, dot));
  }
  EXPECT_EQ(probed, sections) << "a new section needs a test that its parameters act";
}

}  // namespace
}  // namespace atlas::experiments
