#include "robots/robot_files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "core/files.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "sim/world/world_model.h"

#include <mujoco/mujoco.h>

namespace atlas::robots {
namespace {
namespace fs = std::filesystem;

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class RobotFiles : public ::testing::Test {
 protected:
  RobotFiles() { fs::remove_all(root_); }
  ~RobotFiles() override { fs::remove_all(root_); }

  /// The quadruped with two meshes on its base, from two folders, under its own meshdir.
  fs::path WriteRobotWithMeshes() const {
    std::string xml = core::ReadFile(core::InstalledFile("robots/quadruped.xml"));
    const auto insert = [&xml](const std::string& after, const std::string& text) {
      const size_t at = xml.find(after);
      ASSERT_NE(at, std::string::npos) << after;
      xml.insert(xml.find('>', at) + 1, text);
    };
    insert("<compiler", "<compiler meshdir=\"stl\"/>");
    insert("<asset",
           "<mesh name=\"hull\" file=\"hull.obj\"/><mesh name=\"fin\" file=\"../other/hull.obj\"/>");
    insert("<body name=\"base\"",
           "<geom type=\"mesh\" mesh=\"hull\" class=\"seen\"/><geom type=\"mesh\" mesh=\"fin\" "
           "class=\"seen\"/>");
    core::WriteFileAtomically(root_ / "mine/dog.xml", xml);
    core::WriteFileAtomically(root_ / "mine/stl/hull.obj", kTetrahedron);
    core::WriteFileAtomically(root_ / "mine/other/hull.obj",
                              fmt::format("{}v 0 0 0.2\nf 2 3 5\n", kTetrahedron));
    return root_ / "mine/dog.xml";
  }
  static int MeshesOf(const fs::path& mjcf) {
    return sim::CompileModel(scenes::LoadScene("car"), LoadRobot(mjcf.string()))->nmesh;
  }

  const fs::path root_ = fs::temp_directory_path() / "atlas_robot_files";
};

TEST_F(RobotFiles, ARobotWithMeshesWalksFromItsOwnFolder) {
  const int without = MeshesOf(core::InstalledFile("robots/quadruped.xml"));
  EXPECT_EQ(MeshesOf(WriteRobotWithMeshes()), without + 2);
}

TEST_F(RobotFiles, ACopyIsTheSameRobotWithoutTheOriginals) {
  const fs::path original = WriteRobotWithMeshes();
  const int meshes = MeshesOf(original);
  const std::string digest = RobotDigest(original.string());
  EXPECT_EQ(CopyRobot(original.string(), root_ / "run/robot"), "dog.xml");
  fs::remove_all(root_ / "mine");
  fs::rename(root_ / "run", root_ / "moved");
  const fs::path copy = root_ / "moved/robot/dog.xml";
  EXPECT_EQ(MeshesOf(copy), meshes);
  EXPECT_EQ(RobotDigest(copy.string()), digest);
}

TEST_F(RobotFiles, AllFilesOfARobotAreListed) {
  const fs::path robot = WriteRobotWithMeshes();
  std::string xml = core::ReadFile(robot);
  core::WriteFileAtomically(root_ / "mine/parts/more.xml", "<mujoco></mujoco>");
  core::WriteFileAtomically(robot, xml.insert(xml.rfind("</mujoco>"), "<include file=\"parts/more.xml\"/>"));
  std::set<fs::path> files;
  for (const fs::path& file : FilesOfRobot(robot.string())) files.insert(file.lexically_normal());
  EXPECT_EQ(files, (std::set<fs::path>{robot, root_ / "mine/stl/hull.obj", root_ / "mine/other/hull.obj",
                                       root_ / "mine/parts/more.xml"}));
}

TEST_F(RobotFiles, TheDigestFollowsModelAndMeshes) {
  const fs::path robot = WriteRobotWithMeshes();
  const std::string digest = RobotDigest(robot.string()), xml = core::ReadFile(robot);
  EXPECT_TRUE(digest.starts_with("dog-")) << digest;
  core::WriteFileAtomically(robot, xml + "<!-- a comment -->\n");
  EXPECT_EQ(RobotDigest(robot.string()), digest);
  std::string heavier = xml;
  heavier.replace(heavier.find("armature=\"0.04\""), 15, "armature=\"0.05\"");
  core::WriteFileAtomically(robot, heavier);
  EXPECT_NE(RobotDigest(robot.string()), digest);
  core::WriteFileAtomically(robot, xml);
  core::WriteFileAtomically(root_ / "mine/stl/hull.obj", fmt::format("{}\n", kTetrahedron));
  EXPECT_NE(RobotDigest(robot.string()), digest);
}

TEST_F(RobotFiles, ABuiltInRobotIsTheRobotOfItsFile) {
  for (const CatalogEntry& entry : Catalog()) {
    const RobotSpec built_in = LoadRobot(entry.name);
    const fs::path copy = root_ / entry.name / CopyRobot(entry.name, root_ / entry.name);
    const RobotSpec read = LoadRobot(copy.string());
    EXPECT_EQ(read.name, built_in.name);
    EXPECT_EQ(read.lidar_model, built_in.lidar_model);
    EXPECT_TRUE(read.T_base_lidar.isApprox(built_in.T_base_lidar));
    EXPECT_TRUE(read.T_base_depth.isApprox(built_in.T_base_depth));
    EXPECT_EQ(read.stance_height_m, built_in.stance_height_m);
    EXPECT_EQ(read.footprint_radius_m, built_in.footprint_radius_m);
    EXPECT_EQ(read.half_length_m, built_in.half_length_m);
    EXPECT_EQ(read.half_width_m, built_in.half_width_m);
    EXPECT_EQ(read.body_top_m, built_in.body_top_m);
    EXPECT_EQ(read.max_speed_mps, built_in.max_speed_mps);
    EXPECT_EQ(read.max_step_m, built_in.max_step_m);
    EXPECT_EQ(read.max_slope_rad, built_in.max_slope_rad);
    EXPECT_EQ(RobotDigest(copy.string()), RobotDigest(entry.name));
  }
}

}  // namespace
}  // namespace atlas::robots
