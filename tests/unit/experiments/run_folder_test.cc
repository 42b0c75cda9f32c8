#include "experiments/run_folder.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/run_identity.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

class RunFolderTest : public ::testing::Test {
 protected:
  RunFolderTest() { fs::remove_all(root_); }
  ~RunFolderTest() override { fs::remove_all(root_); }
  void Write(const std::string& name, const std::string& text) const {
    core::WriteFileAtomically(root_ / name, text);
  }
  const fs::path root_ = fs::temp_directory_path() / "atlas_run_folder";
};

TEST_F(RunFolderTest, ANumberedRunNeverTouchesAnEarlierOne) {
  const fs::path one = root_ / "runs/car/1";
  EXPECT_EQ(OpenRunFolder(one, true, false), one);
  Write("runs/car/1/summary.json", "first");
  EXPECT_EQ(OpenRunFolder(one, true, false), root_ / "runs/car/1-2");  // made, and as yet empty
  EXPECT_EQ(OpenRunFolder(one, true, false), root_ / "runs/car/1-3");
  EXPECT_EQ(core::ReadFile(one / "summary.json"), "first");
}

TEST_F(RunFolderTest, ANamedFolderThatHoldsARunIsRefusedUnlessForced) {
  Write("mine/summary.json", "first");
  Write("mine/map.bt", "of the run before");
  Write("mine/scene/old.yaml", "x");
  Write("mine/notes.txt", "the user's own");
  try {
    OpenRunFolder(root_ / "mine", false, false);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              (root_ / "mine").string() + ": holds a run already (--force to replace it)");
  }
  EXPECT_EQ(core::ReadFile(root_ / "mine/summary.json"), "first");
  EXPECT_EQ(OpenRunFolder(root_ / "mine", false, true), root_ / "mine");
  EXPECT_FALSE(fs::exists(root_ / "mine/summary.json"));
  EXPECT_FALSE(fs::exists(root_ / "mine/map.bt"));
  EXPECT_FALSE(fs::exists(root_ / "mine/scene"));
  EXPECT_TRUE(fs::exists(root_ / "mine/notes.txt"));
}

TEST_F(RunFolderTest, AFolderWithoutARunIsTaken) {
  Write("mine/notes.txt", "x");
  EXPECT_EQ(OpenRunFolder(root_ / "mine", false, false), root_ / "mine");
  Write("file", "x");
  EXPECT_THROW(OpenRunFolder(root_ / "file", false, false), core::InputError);
  EXPECT_THROW(OpenRunFolder(root_ / "file/run", true, false), core::InputError);
}

class KeptInputs : public RunFolderTest {
 protected:
  KeptInputs() {
    Write("mine/exp/walk.yaml",
          "extends: helicopter\nscene: ../scenes/shed.yaml\nplanner: {nodes: 20}\nrobot: ../dog.xml\n");
    Write("mine/scenes/shed.yaml",
          "spawn: {x: -4, y: 0}\nobject_box: {min: [-1, -1, 0.05], max: [1, 1, 2]}\nparts:\n"
          "  - {mesh: ../shed.obj}\n");
    Write("mine/shed.obj", "v 0 0 0.1\nv 1 0 0.1\nv 0 1 0.1\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    Write("mine/dog.xml", core::ReadFile(core::InstalledFile("robots/quadruped.xml")));
  }
  ExperimentConfig Load() const { return LoadExperiment((root_ / "mine/exp/walk.yaml").string(), {}); }
  /// As a run does.
  void Keep() const {
    const ExperimentConfig kept = KeepInputs(Load(), root_ / "run");
    core::WriteFileAtomically(root_ / "run/config.yaml", core::DumpYaml(kept.rows));
  }
};

TEST_F(KeptInputs, AMovedFolderIsTheSameExperimentWithoutTheOriginals) {
  Keep();
  const RunIdentity identity = IdentityOf(Load());
  const RunSettings settings = SettingsOf(Load().rows);
  fs::remove_all(root_ / "mine");
  fs::rename(root_ / "run", root_ / "moved");
  const ExperimentConfig again = LoadExperiment((root_ / "moved/config.yaml").string(), {});
  EXPECT_EQ(again.experiment, "walk");
  EXPECT_EQ(again.planner.nodes, 20);
  EXPECT_EQ(again.scene.name, (root_ / "moved/scene/shed.yaml").string());
  EXPECT_EQ(again.robot.name, (root_ / "moved/robot/dog.xml").string());
  EXPECT_EQ(scenes::LoadScene(again.scene.name).parts.size(), 2u);
  EXPECT_EQ(DifferingPaths(SettingsOf(again.rows), settings),
            (std::vector<std::string>{"robot.name", "scene.name"}));
  EXPECT_EQ(IdentityOf(again).config_hash, identity.config_hash);
  EXPECT_EQ(core::ReadFile(root_ / "moved/config.yaml").find(root_.string()), std::string::npos);
}

TEST_F(KeptInputs, TheHashFollowsParametersSceneMeshAndRobot) {
  const std::string hash = IdentityOf(Load()).config_hash;
  EXPECT_EQ(IdentityOf(Load()).config_hash, hash);
  const auto changed = [&](const std::string& file, const std::string& from, const std::string& to) {
    const std::string before = core::ReadFile(root_ / file);
    std::string after = before;
    after.replace(after.find(from), from.size(), to);
    Write(file, after);
    const bool differs = IdentityOf(Load()).config_hash != hash;
    Write(file, before);
    return differs;
  };
  EXPECT_TRUE(changed("mine/exp/walk.yaml", "nodes: 20", "nodes: 21"));
  EXPECT_TRUE(changed("mine/scenes/shed.yaml", "x: -4", "x: -3.9"));
  EXPECT_TRUE(changed("mine/shed.obj", "v 1 0", "v 2 0"));
  EXPECT_TRUE(changed("mine/dog.xml", "armature=\"0.04\"", "armature=\"0.05\""));
  EXPECT_FALSE(changed("mine/exp/walk.yaml", "planner:", "# no change\nplanner:"));
  EXPECT_EQ(
      IdentityOf(LoadExperiment((root_ / "mine/exp/walk.yaml").string(), {"output.video=true"})).config_hash,
      hash);  // what is written beside changes no result
}

TEST_F(KeptInputs, BadScenesAreNamedByTheUsersFileAndNothingIsKept) {
  Write("mine/shed.obj", "");
  try {
    Keep();
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("mine/scenes/shed.yaml:4"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(root_ / "run/scene"));
}

TEST(ExperimentNames, AreNamesOfFolders) {
  EXPECT_EQ(LoadExperiment("car", {"experiment=my-car_2"}).experiment, "my-car_2");
  for (const char* name : {"../x", "a/b", "..", "a b", "a\nb", ""}) {
    EXPECT_THROW(LoadExperiment("car", {std::string("experiment=\"") + name + "\""}), core::InputError)
        << name;
  }
}

}  // namespace
}  // namespace atlas::experiments
