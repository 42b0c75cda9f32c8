// Sensor mounts as the robot's model states them, and models that lack what the simulator needs.
#include "robots/robot_spec.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/errors.h"
#include "core/files.h"
#include "robots/robot_files.h"

namespace atlas::robots {
namespace {

using core::Vec3;

class RobotFile : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// The built-in robot's model with `from` replaced by `to`.
  std::string With(const std::string& from, const std::string& to) const {
    std::string xml = core::ReadFile(core::InstalledFile("robots/quadruped.xml"));
    const size_t at = xml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    core::WriteFileAtomically(folder_ / "robot.xml", xml.replace(at, from.size(), to));
    return (folder_ / "robot.xml").string();
  }
  static std::string RefusalOf(const std::string& file) {
    try {
      LoadRobot(file);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("atlas_robot_spec_" + std::to_string(::getpid()));
};

TEST(Quadruped, CarriesItsLidarUprightOnTopAndItsCameraLookingAheadAndDown) {
  const RobotSpec robot = LoadRobot("quadruped");
  EXPECT_LT((robot.T_base_lidar.translation() - Vec3(0.0, 0.0, 0.25)).norm(), 1e-9);
  EXPECT_LT((robot.T_base_lidar.linear() - core::Mat3::Identity()).norm(), 1e-9);
  const core::Mat3 R_base_camera = robot.T_base_depth.linear();
  EXPECT_GT(robot.T_base_depth.translation().x(), 0.25);
  EXPECT_LT((R_base_camera * Vec3::UnitX() - Vec3(0.0, -1.0, 0.0)).norm(), 1e-4) << "x of a camera is right";
  const Vec3 ahead = R_base_camera * Vec3::UnitZ();
  EXPECT_NEAR(core::Degrees(std::asin(-ahead.z())), 32.0, 1.0);
  EXPECT_GT(ahead.x(), 0.8);
}

TEST_F(RobotFile, MountsAreReadFromTheFileAndNormalised) {
  const RobotSpec robot = LoadRobot(With("<site name=\"lidar\" pos=\"0 0 0.25\"/>",
                                         "<site name=\"lidar\" pos=\"0.1 -0.2 0.3\" quat=\"2 0 0 2\"/>"));
  EXPECT_LT((robot.T_base_lidar.translation() - Vec3(0.1, -0.2, 0.3)).norm(), 1e-9);
  EXPECT_NEAR(core::YawOf(robot.T_base_lidar.linear()), core::kPi / 2, 1e-9);
  EXPECT_NEAR(robot.T_base_lidar.linear().determinant(), 1.0, 1e-9);
}

TEST_F(RobotFile, WhatTheSimulatorNeedsIsNamedWhereItIsMissing) {
  EXPECT_NE(RefusalOf(With("<site name=\"lidar\"", "<site name=\"ladar\"")).find("no site 'lidar'"),
            std::string::npos);
  EXPECT_NE(RefusalOf(With("joint name=\"RH_HFE\"", "joint name=\"RH_XXX\"")).find("RH_HFE"),
            std::string::npos);
  EXPECT_NE(RefusalOf(With("geom name=\"LF_FOOT\"", "geom name=\"LF_TOE\"")).find("LF_FOOT"),
            std::string::npos);
  EXPECT_NE(RefusalOf(With("pos=\"0 0 0.25\"", "pos=\"0 0\"")).find("lidar"), std::string::npos);
  EXPECT_NE(RefusalOf("quadrupod").find("quadruped"), std::string::npos);
}

TEST_F(RobotFile, ElementsNestedTooDeeplyAreRefusedHoweverTheirTagsAreSpelt) {
  const std::filesystem::path file = folder_ / "deep.xml";
  const auto refusal = [&](const std::string& tag, int levels) {
    std::string xml = "<!-- <a> -->\n";
    for (int i = 0; i < levels; ++i) xml += tag;
    core::WriteFileAtomically(file, xml);
    return RefusalOf(file.string());
  };
  const std::string too_deep = file.string() + ":2: elements are nested deeper than 256 levels";
  for (const char* tag : {"<a>", "<a b='/>'>", "<a\tb = \"</a>\" >", "<a><!-- </a></a> --><c/>", "<a><b></b>",
                          "<a><![CDATA[</a>]]>", "<a><?x </a>?>"}) {
    EXPECT_EQ(refusal(tag, 100000), too_deep) << tag;
    EXPECT_EQ(refusal(tag, 257), too_deep) << tag;
    EXPECT_NE(refusal(tag, 250).find("malformed XML"), std::string::npos) << tag;  // never closed
  }
  for (const char* tag : {"<a\"b>\"/>", "<a=\">\"/>", "<a \"b=\"/>\">", "<!DOCTYPE [</a>]><a>", "<a b<c>"}) {
    EXPECT_NE(refusal(tag, 100000).find("malformed XML"), std::string::npos) << tag;
  }
}

TEST_F(RobotFile, IncludesWithoutEndAndFilesWithoutEndAreRefused) {
  for (int level = 0; level < 12; ++level) {
    std::string xml = "<mujoco>";
    for (int i = 0; i < 8; ++i) xml += fmt::format("<include file='{}.xml'/>", level + 1);
    core::WriteFileAtomically(folder_ / fmt::format("{}.xml", level), xml + "</mujoco>");
  }
  core::WriteFileAtomically(folder_ / "12.xml", "<mujoco/>");
  const auto refusal = [&](const std::string& body) {
    const std::string file = With("<worldbody>", body + "<worldbody>");
    try {
      FilesOfRobot(file);
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_TRUE(refusal("<include file='0.xml'/>").ends_with(": one include more than 256"));
  EXPECT_NE(refusal("<include file='/dev/zero'/>").find("/dev/zero: is a device"), std::string::npos);
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(refusal("<include file='pipe'/>").find("a pipe, not a file"), std::string::npos);
  EXPECT_NE(refusal("<asset><texture name='t' type='2d' file='pipe'/></asset>").find("a pipe, not a file"),
            std::string::npos);
}

TEST_F(RobotFile, SiblingsAreNotDepthAndMarkupInTextsAndCommentsIsNone) {
  std::string flat;
  for (int i = 0; i < 1000; ++i) flat += "<geom name='g' size='1 > 2'/><!-- <a> --><body></body>";
  EXPECT_EQ(RefusalOf(With("<worldbody>", "<worldbody>" + flat)), "");
}

TEST_F(RobotFile, ANameThatNoFileCanHaveIsMissing) {
  const std::string name = fmt::format("{:x>300}.xml", "");
  EXPECT_EQ(RefusalOf(name), name + ": no such file");
  EXPECT_NE(RefusalOf(folder_.string() + "/..xml").find("no such file"), std::string::npos);
}

TEST(Quadruped, IsAsHighAndWideAsItsSpecSays) {
  const RobotSpec robot = LoadRobot("quadruped");
  EXPECT_GT(robot.body_top_m, robot.T_base_lidar.translation().z() + 0.03) << "the LiDAR is part of the body";
  EXPECT_GE(robot.footprint_radius_m, robot.half_length_m);
  EXPECT_GT(robot.half_length_m, robot.half_width_m);
}

}  // namespace
}  // namespace atlas::robots
