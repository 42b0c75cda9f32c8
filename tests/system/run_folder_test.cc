// A run folder is whole: moved, its originals gone, it renders and runs again to the same bytes.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "core/files.h"
#include "tests/support/command_line.h"

namespace {

namespace fs = std::filesystem;

using atlas::core::ReadFile;
using atlas::core::WriteFileAtomically;
using atlas::tests::CommandLine;
using atlas::tests::Outcome;

class WholeRunFolder : public CommandLine {
 protected:
  /// One scan of a small pyramid by the kinematic robot: seconds.
  void WriteOriginals() const {
    WriteFileAtomically(dir_ / "mine/exp/walk.yaml",
                        "extends: helicopter\nscene: ../scenes/tent.yaml\nlocomotion: kinematic\n"
                        "planner: {nodes: 5, rays: 500}\nmission: {max_scans: 1, truth_spacing_m: 0.05}\n");
    WriteFileAtomically(dir_ / "mine/scenes/tent.yaml",
                        "spawn: {x: -3, y: 0}\nobject_box: {min: [-1, -1, 0.05], max: [1, 1, 1.5]}\nparts:\n"
                        "  - {mesh: ../meshes/tent.obj}\n");
    WriteFileAtomically(dir_ / "mine/meshes/tent.obj",
                        "v -0.8 -0.8 0\nv 0.8 -0.8 0\nv 0.8 0.8 0\nv -0.8 0.8 0\nv 0 0 1.2\n"
                        "f 1 3 2\nf 1 4 3\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
  }
  /// All files of the test.
  std::map<fs::path, std::string> Contents() const {
    std::map<fs::path, std::string> contents;
    for (const auto& file : fs::recursive_directory_iterator(dir_)) {
      if (file.is_regular_file()) contents[file.path()] = ReadFile(file.path());
    }
    return contents;
  }
  void ExpectSuccess(const std::string& arguments, const std::string& words = "") {
    const Outcome outcome = Atlas(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.text;
    EXPECT_NE(outcome.text.find(words), std::string::npos) << arguments << "\n" << outcome.text;
  }
};

TEST_F(WholeRunFolder, MovedWithoutItsOriginalsItRendersAndRunsAgainToTheSameBytes) {
  WriteOriginals();
  ExpectSuccess("run mine/exp/walk.yaml --seed 4 --out first");
  const std::string steps = ReadFile(dir_ / "first/steps.csv"), cloud = ReadFile(dir_ / "first/cloud.ply");
  EXPECT_NE(steps.find("\n1,"), std::string::npos);
  fs::create_directories(dir_ / "elsewhere");
  fs::rename(dir_ / "first", dir_ / "elsewhere/kept");
  fs::remove_all(dir_ / "mine");

  ExpectSuccess("render elsewhere/kept --still --size 64x48 --out picture.png");
  EXPECT_TRUE(fs::exists(dir_ / "picture.png"));
  ExpectSuccess("run elsewhere/kept/config.yaml", "runs/walk/4");
  EXPECT_EQ(ReadFile(dir_ / "runs/walk/4/steps.csv"), steps);
  EXPECT_EQ(ReadFile(dir_ / "runs/walk/4/cloud.ply"), cloud);
  EXPECT_EQ(ReadFile(dir_ / "runs/walk/4/config.yaml"), ReadFile(dir_ / "elsewhere/kept/config.yaml"));

  ExpectSuccess("report runs elsewhere --out tables", "left out, same configuration and seed as another");
  ExpectRefusal("run elsewhere/kept/config.yaml --out elsewhere/kept",
                {"elsewhere/kept", "choose another --out"});
  ExpectRefusal("run helicopter --out elsewhere/kept", {"elsewhere/kept", "--force"});
}

TEST_F(WholeRunFolder, NothingOfTheUsersIsTouched) {
  WriteOriginals();
  WriteFileAtomically(dir_ / "mine/scene/site.yaml", "# mine\n");
  WriteFileAtomically(dir_ / "mine/config.yaml", "# mine too\n");
  WriteFileAtomically(dir_ / "mine/scenes/typo.yaml", "spawn: {x: [}\n");
  const auto before = Contents();
  ExpectRefusal("run mine/exp/walk.yaml --out mine", {"mine", "is made from"});
  ExpectRefusal("run mine/exp/walk.yaml --out mine --force", {"mine", "is made from"});
  for (const char* force : {"", " --force"}) {
    ExpectRefusal(std::string("run helicopter --out mine") + force, {"mine: holds no run, but 'scene'"});
    ExpectRefusal(std::string("run helicopter --set robot=typo.xml --out mine") + force, {"typo.xml"});
    ExpectRefusal(std::string("run mine/exp/walk.yaml --set scene=mine/scenes/typo.yaml --out mine") + force,
                  {"typo.yaml"});
  }
  EXPECT_EQ(Contents(), before);
}

TEST_F(WholeRunFolder, ARunIsReplacedOnlyByOneWhoseInputsAreSound) {
  WriteOriginals();
  ExpectSuccess("run mine/exp/walk.yaml --seed 4 --out first");
  WriteFileAtomically(dir_ / "first/notes.txt", "mine\n");
  WriteFileAtomically(dir_ / "mine/bad.xml", "<mujoco/>\n");
  const auto before = Contents();
  ExpectRefusal("run first/config.yaml --out first --force", {"first", "choose another --out"});
  ExpectRefusal("map --scans mine --poses mine/poses.txt --out first", {"first: holds a run"});
  ExpectRefusal("run mine/exp/walk.yaml --set scene=first/scene/tent.yaml --out first --force", {"first"});
  ExpectRefusal("run mine/exp/walk.yaml --set robot=mine/bad.xml --out first --force", {"bad.xml"});
  ExpectRefusal("run mine/exp/walk.yaml --set scene=absent.yaml --out first --force", {"absent.yaml"});
  EXPECT_EQ(Contents(), before);
  ExpectSuccess("run mine/exp/walk.yaml --seed 5 --out first --force");
  EXPECT_EQ(ReadFile(dir_ / "first/notes.txt"), "mine\n");
  EXPECT_NE(ReadFile(dir_ / "first/config.yaml"), before.at(dir_ / "first/config.yaml"));
}

TEST_F(WholeRunFolder, ASweepReplacesWhatAKilledRunLeft) {
  WriteOriginals();
  WriteFileAtomically(dir_ / "mine/two.yaml", "experiments: [exp/walk.yaml]\nseeds: 1\n");
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 runs: 1 new; 1 to run");
  const fs::path summary = dir_ / "swept/walk/1/summary.json";
  WriteFileAtomically(summary, ReadFile(summary).substr(0, 40));
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 broken (damaged); 1 to run");
  fs::remove(summary);
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 new; 1 to run");
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 runs: 1 done; 0 to run");
}

TEST_F(WholeRunFolder, ASweepTellsWhatAnEditedExperimentMadeStale) {
  WriteOriginals();
  WriteFileAtomically(dir_ / "mine/two.yaml", "experiments: [exp/walk.yaml]\nseeds: 1\n");
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 runs: 1 new; 1 to run");
  ExpectSuccess("sweep mine/two.yaml --out swept", "1 runs: 1 done; 0 to run");
  std::string walk = ReadFile(dir_ / "mine/exp/walk.yaml");
  WriteFileAtomically(dir_ / "mine/exp/walk.yaml", walk.replace(walk.find("nodes: 5"), 8, "nodes: 6"));
  std::string mesh = ReadFile(dir_ / "mine/meshes/tent.obj");
  WriteFileAtomically(dir_ / "mine/meshes/tent.obj", mesh.replace(mesh.find("1.2"), 3, "1.1"));
  ExpectSuccess("sweep mine/two.yaml --out swept --keep-stale", "1 stale (planner.nodes, scene changed)");
  EXPECT_NE(ReadFile(dir_ / "swept/table.md").find("`./atlas sweep mine/two.yaml --out swept --keep-stale`"),
            std::string::npos);
}

}  // namespace
