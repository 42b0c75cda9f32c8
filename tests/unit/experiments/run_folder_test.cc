#include "experiments/results/run_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/identity/run_identity.h"
#include "experiments/results/run_summary.h"
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
  void WriteRun(const std::string& folder, const std::string& experiment) const {
    RunSummary summary;
    summary.experiment = experiment;
    summary.config_hash = "1a2b";
    Write(folder + "/summary.json", ToJson(summary));
  }
  RunFolderRequest Named(const std::string& folder, bool force = false) const {
    return {.folder = root_ / folder, .force = force, .experiment = "walk", .seed = 7};
  }
  /// What is said against a folder; empty where it is taken.
  static std::string Refusal(const RunFolderRequest& request) {
    try {
      OpenRunFolder(request);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  /// All files below a folder of the test.
  std::map<fs::path, std::string> Contents(const std::string& folder = "") const {
    std::map<fs::path, std::string> contents;
    for (const auto& file : fs::recursive_directory_iterator(root_ / folder)) {
      if (file.is_regular_file()) contents[file.path()] = core::ReadFile(file.path());
    }
    return contents;
  }
  const fs::path root_ = fs::temp_directory_path() / "atlas_run_folder";
};

TEST_F(RunFolderTest, ANumberedRunNeverTouchesAnEarlierOne) {
  const RunFolderRequest one{.folder = root_ / "runs/car/1", .numbered = true, .experiment = "car"};
  EXPECT_EQ(OpenRunFolder(one), root_ / "runs/car/1");
  Write("runs/car/1/summary.json", "first");
  EXPECT_EQ(OpenRunFolder(one), root_ / "runs/car/1-2");
  EXPECT_EQ(OpenRunFolder(one), root_ / "runs/car/1-3");
  EXPECT_EQ(core::ReadFile(root_ / "runs/car/1/summary.json"), "first");
}

TEST_F(RunFolderTest, ANamedFolderThatHoldsARunIsRefusedUnlessForced) {
  WriteRun("mine", "first");
  Write("mine/map.bt", "of the run before");
  Write("mine/scene/old.yaml", "x");
  Write("mine/inputs.txt", "scene/old.yaml\n");
  Write("mine/notes.txt", "the user's own");
  const auto before = Contents();
  EXPECT_EQ(Refusal(Named("mine")),
            (root_ / "mine").string() + ": holds a run already (--force to replace it)");
  EXPECT_EQ(Contents(), before);
  EXPECT_EQ(OpenRunFolder(Named("mine", true)), root_ / "mine");
  EXPECT_FALSE(fs::exists(root_ / "mine/map.bt"));
  EXPECT_FALSE(fs::exists(root_ / "mine/scene"));
  EXPECT_TRUE(fs::exists(root_ / "mine/notes.txt"));
  const RunSummary claim = LoadRunSummary(root_ / "mine");
  EXPECT_EQ(claim.experiment, "walk");
  EXPECT_EQ(claim.seed, 7u);
  EXPECT_EQ(claim.status, RunStatus::kInterrupted);
}

TEST_F(RunFolderTest, AFolderInWhichARunGoesOnIsRefusedEvenByForce) {
  core::FolderLock held;
  RunFolderRequest first = Named("mine");
  first.lock = &held;
  OpenRunFolder(first);
  WriteRun("mine", "walk");
  EXPECT_NE(Refusal(Named("mine", true)).find("another process works there"), std::string::npos);
  EXPECT_NE(Refusal(Named("mine")).find("holds a run"), std::string::npos);
  held = core::FolderLock();
  EXPECT_EQ(Refusal(Named("mine", true)), "");
}

TEST_F(RunFolderTest, AFolderWithoutARunIsTaken) {
  Write("mine/notes.txt", "x");
  EXPECT_EQ(OpenRunFolder(Named("mine")), root_ / "mine");
  Write("file", "x");
  EXPECT_THROW(OpenRunFolder(Named("file")), core::InputError);
  EXPECT_THROW(OpenRunFolder({.folder = root_ / "file/run", .numbered = true, .experiment = "walk"}),
               core::InputError);
}

TEST_F(RunFolderTest, WhatIsNoRunsIsNeitherReplacedNorOverwritten) {
  for (const char* own : {"scene/site.yaml", "robot/dog.xml", "config.yaml", "summary.json", "log.txt"}) {
    const std::string folder = "own_" + fs::path(own).filename().string();
    Write(folder + "/" + own, "{\"name\": \"the user's own\"}\n");
    const auto before = Contents();
    for (const bool force : {false, true}) {
      const std::string refusal = Refusal(Named(folder, force));
      EXPECT_NE(refusal.find("holds no run, but '" + fs::path(own).begin()->string() + "'"),
                std::string::npos)
          << refusal;
      EXPECT_EQ(refusal.find("--force"), std::string::npos) << refusal;
    }
    EXPECT_EQ(Contents(), before) << own;
  }
}

TEST_F(RunFolderTest, AFolderThatHoldsAnInputIsRefusedAndKept) {
  WriteRun("run", "first");
  Write("run/config.yaml", "x");
  Write("elsewhere/scene.yaml", "x");
  fs::create_directory_symlink(root_ / "run", root_ / "link");
  fs::create_symlink(root_ / "elsewhere/scene.yaml", root_ / "run/linked.yaml");
  const auto before = Contents();
  const fs::path inputs[] = {root_ / "run/config.yaml", root_ / "link/config.yaml", root_ / "run/linked.yaml",
                             root_ / "elsewhere/../run/config.yaml"};
  for (const fs::path& input : inputs) {
    for (const char* folder : {"run", "run/", "link", "elsewhere/../run"}) {
      RunFolderRequest request = Named(folder, true);
      request.inputs = {root_ / "elsewhere/scene.yaml", input};
      EXPECT_NE(Refusal(request).find("is made from " + input.string()), std::string::npos)
          << input << " " << folder;
      EXPECT_EQ(Contents(), before);
    }
  }
  RunFolderRequest request = Named("run", true);
  request.inputs = {root_ / "elsewhere/scene.yaml", root_ / "run2/config.yaml"};
  EXPECT_EQ(Refusal(request), "");
}

TEST_F(RunFolderTest, WhatIsDiscardedIsWhatWasMadeWhereNoRunHasBegun) {
  OpenRunFolder(Named("new"));
  Write("new/scene/copy.yaml", "x");
  Write("new/inputs.txt", "scene/copy.yaml\n");
  DiscardInputs(root_ / "new");
  EXPECT_FALSE(fs::exists(root_ / "new"));

  Write("mine/notes.txt", "x");
  OpenRunFolder(Named("mine"));
  DiscardInputs(root_ / "mine");
  EXPECT_EQ(Contents("mine").size(), 1u);

  Write("own/scene/site.yaml", "x");
  DiscardInputs(root_ / "own");
  EXPECT_TRUE(fs::exists(root_ / "own/scene/site.yaml"));

  WriteRun("begun", "walk");
  Write("begun/scene/copy.yaml", "x");
  DiscardInputs(root_ / "begun");
  EXPECT_TRUE(fs::exists(root_ / "begun/scene/copy.yaml"));
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
  EXPECT_EQ(core::DumpYaml(again.rows).find("nodes: 21"), std::string::npos);
  EXPECT_NE(core::DumpYaml(again.rows).find("nodes: 20"), std::string::npos);
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

TEST_F(KeptInputs, AForcedRunRemovesItsCopiesAndNothingThatLiesBesideThem) {
  OpenRunFolder(Named("run"));
  Keep();
  Write("run/scene/notes.txt", "mine");
  Write("run/robot/mine/gripper.xml", "mine");
  Write("elsewhere/kept.obj", "mine");
  fs::create_directory_symlink(root_ / "elsewhere", root_ / "run/robot/link");
  const std::string list = core::ReadFile(root_ / "run/inputs.txt");
  EXPECT_NE(list.find("scene/shed.yaml\n"), std::string::npos) << list;
  EXPECT_NE(list.find("robot/dog.xml\n"), std::string::npos) << list;
  Write("run/inputs.txt",
        list + "scene/../../elsewhere/kept.obj\nrobot/link/kept.obj\nnotes\n/etc/hostname\n");
  Write("run/notes", "mine");
  OpenRunFolder(Named("run", true));
  for (const char* kept :
       {"run/scene/notes.txt", "run/robot/mine/gripper.xml", "elsewhere/kept.obj", "run/notes"}) {
    EXPECT_EQ(core::ReadFile(root_ / kept), "mine");
  }
  for (const char* gone :
       {"run/scene/shed.yaml", "run/scene/shed.obj", "run/robot/dog.xml", "run/inputs.txt"}) {
    EXPECT_FALSE(fs::exists(root_ / gone)) << gone;
  }
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

TEST_F(KeptInputs, AreCheckedAndListedBeforeAnythingIsWritten) {
  Write("mine/exp/base.yaml", "extends: helicopter\nplanner: {nodes: 20}\n");
  Write("mine/exp/walk.yaml", "extends: base\nscene: ../scenes/shed.yaml\nrobot: ../dog.xml\n");
  const std::string experiment = (root_ / "mine/exp/walk.yaml").string();
  const std::vector<fs::path> inputs = CheckedInputs(Load(), experiment);
  for (const char* name : {"mine/exp/walk.yaml", "mine/exp/base.yaml", "mine/scenes/shed.yaml",
                           "mine/shed.obj", "mine/dog.xml"}) {
    EXPECT_TRUE(std::any_of(inputs.begin(), inputs.end(), [&](const fs::path& input) {
      return input.lexically_normal() == root_ / name;
    })) << name;
  }
  std::string robot = core::ReadFile(root_ / "mine/dog.xml");
  Write("mine/dog.xml", robot.replace(robot.find("armature"), 8, "armatura"));
  EXPECT_THROW(CheckedInputs(Load(), experiment), core::InputError);
  fs::remove(root_ / "mine/shed.obj");
  EXPECT_THROW(CheckedInputs(Load(), experiment), core::InputError);
  EXPECT_FALSE(fs::exists(root_ / "run"));
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
