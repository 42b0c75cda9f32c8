// Nothing that decides knows the truth: a run that is lied to about it is the same run, but for what the
// judge says.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "sim/simulator.h"
#include "tests/support/tiny_mission.h"

namespace atlas::tests {
namespace {

namespace fs = std::filesystem;

/// Tells everyone who asks for the truth that the robot stands at one wrong place.
class LyingSimulator final : public sim::Simulator {
 public:
  explicit LyingSimulator(std::unique_ptr<sim::Simulator> honest)
      : honest_(std::move(honest)), false_state_(honest_->TrueState()) {}

  core::Pose TrueBasePose() const override { return core::PoseFromXyzYaw({3.0, -2.0, 0.7}, 1.0); }
  sim::Snapshot TrueState() const override { return {honest_->time_s(), false_state_.qpos}; }
  void AddStateObserver(std::function<void(const sim::Snapshot&)> observer, double rate_hz) override {
    honest_->AddStateObserver(
        [this, observer](const sim::Snapshot& state) {
          observer({state.time_s, false_state_.qpos});
        },
        rate_hz);
  }

  void SetSink(core::SensorSink* sink) override { honest_->SetSink(sink); }
  void SetStop(std::function<bool()> should_stop) override { honest_->SetStop(std::move(should_stop)); }
  void SetLocalisation(const core::Pose& T_map_odom) override { honest_->SetLocalisation(T_map_odom); }
  sim::MotionStatus Stand(double duration_s) override { return honest_->Stand(duration_s); }
  sim::WalkResult Walk(const sim::WalkPath& path, const core::TerrainView* terrain) override {
    return honest_->Walk(path, terrain);
  }
  sim::MotionStatus RollSweep() override { return honest_->RollSweep(); }
  double time_s() const override { return honest_->time_s(); }
  core::Pose T_odom_base() const override { return honest_->T_odom_base(); }
  const sim::SafetyCounts& safety() const override { return honest_->safety(); }
  std::string render_backend() const override { return honest_->render_backend(); }
  std::string render_problem() const override { return honest_->render_problem(); }

 private:
  std::unique_ptr<sim::Simulator> honest_;
  sim::Snapshot false_state_;
};

std::map<std::string, std::string> FilesOf(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder).string()] = core::ReadFile(entry.path());
  }
  return files;
}

experiments::RunSummary RunMission(const TinyMissions& missions, const std::vector<std::string>& settings,
                                   const std::string& name, bool lied_to) {
  experiments::RunOptions options;
  options.folder = missions.folder() / name;
  if (lied_to) {
    options.interpose = [](std::unique_ptr<sim::Simulator> honest) -> std::unique_ptr<sim::Simulator> {
      return std::make_unique<LyingSimulator>(std::move(honest));
    };
  }
  return experiments::RunClosedLoop(missions.Load(settings), options);
}

/// Files that hold what the judge saw, or how long things took.
const std::set<std::string> kJudged = {"trajectory_truth.tum", "recording.bin", "summary.json",
                                       "timings.csv",          "log.txt",       "coverage.svg"};

/// Names of the files that differ between two runs.
std::set<std::string> DifferentFiles(const TinyMissions& missions) {
  const auto told = FilesOf(missions.folder() / "honest"), lied = FilesOf(missions.folder() / "lied_to");
  EXPECT_GT(told.size(), 8u);
  EXPECT_EQ(told.size(), lied.size());
  std::set<std::string> different;
  for (const auto& [name, bytes] : told) {
    if (lied.count(name) == 0 || lied.at(name) != bytes) different.insert(name);
  }
  return different;
}

class FalseTruth : public ::testing::TestWithParam<std::vector<std::string>> {
 protected:
  TinyMissions missions_;
};

TEST_P(FalseTruth, ChangesNothingButWhatTheJudgeSays) {
  const experiments::RunSummary honest = RunMission(missions_, GetParam(), "honest", false),
                                lied_to = RunMission(missions_, GetParam(), "lied_to", true);
  const std::set<std::string> different = DifferentFiles(missions_);
  for (const std::string& file : different) EXPECT_TRUE(kJudged.count(file) > 0) << file;
  EXPECT_TRUE(different.count("trajectory_truth.tum") > 0) << "or nobody was lied to";
  EXPECT_GT(lied_to.Number("ate_believed_m").value(), honest.Number("ate_believed_m").value() + 1.0);
  EXPECT_EQ(lied_to.Number("coverage").value(), honest.Number("coverage").value());
}

INSTANTIATE_TEST_SUITE_P(Odometry, FalseTruth,
                         ::testing::Values(std::vector<std::string>{"localisation=none", "odometry=drift"},
                                           std::vector<std::string>{"localisation=slam", "odometry=drift",
                                                                    "mapper=atlas"},
                                           std::vector<std::string>{"localisation=slam", "odometry=legs"}));

TEST(LyingSimulatorTest, IsBelievedByTheLocaliserTruth) {
  const TinyMissions missions;
  RunMission(missions, {"localisation=truth"}, "honest", false);
  RunMission(missions, {"localisation=truth"}, "lied_to", true);
  EXPECT_TRUE(DifferentFiles(missions).count("cloud.ply") > 0);
}

}  // namespace
}  // namespace atlas::tests
