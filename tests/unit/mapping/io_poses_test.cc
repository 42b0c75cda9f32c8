#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "mapping/io/recorded_poses.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;

std::string ErrorOf(const std::string& text) {
  try {
    ParsePoses(text, "poses.txt");
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Poses, TumRowsKittiRowsAndMatricesSayTheSame) {
  // A quarter turn about z, then (1, 2, 3).
  const RecordedPoses tum = ParsePoses(
      "# time tx ty tz qx qy qz qw\n\n10.5 1 2 3 0 0 0.70710678 0.70710678 # "
      "first\r\n11,1,2,3,0,0,-0.70710678,-0.70710678\n",
      "a.tum");
  const RecordedPoses kitti = ParsePoses("0 -1 0 1 1 0 0 2 0 0 1 3\n", "a.txt");
  const RecordedPoses matrix = ParsePoses("0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n", "T.txt");
  ASSERT_EQ(tum.size(), 2u);
  EXPECT_EQ(tum.time_s, (std::vector<double>{10.5, 11.0}));
  EXPECT_FALSE(kitti.timed() || matrix.timed());
  for (const Pose& T :
       {tum.T_map_lidar[0], tum.T_map_lidar[1], kitti.T_map_lidar[0], matrix.T_map_lidar[0]}) {
    EXPECT_LT((T * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 1e-7);
    EXPECT_LT((T * Vec3(0, 1, 5) - Vec3(0, 2, 8)).norm(), 1e-7);
  }
}

TEST(Poses, ErrorsNameLineFieldValueAndLimit) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const std::vector<std::pair<std::string, std::vector<const char*>>> cases = {
      {"", {"poses.txt", "no poses"}},
      {"# only a comment\n", {"no poses"}},
      {good + "2 0 0 0 0 0 0\n", {"poses.txt:2", "7 numbers"}},
      {good + "2 0 0 zero 0 0 0 1\n", {"poses.txt:2", "value 4", "zero"}},
      {good + "2 0 nan 0 0 0 0 1\n", {"poses.txt:2", "value 3", "nan"}},
      {good + "2 0 0 0 0 0 0 1.1\n", {"poses.txt:2", "quaternion", "1.1", "0.01"}},
      {good + "2 0 0 0 0 0 0 0\n", {"poses.txt:2", "quaternion"}},
      {good + "0.5 0 0 0 0 0 0 1\n", {"poses.txt:2", "0.5", "1.0", "ascend"}},
      {good + "2 1e20 0 0 0 0 0 1\n", {"poses.txt:2", "1e+20", "limit"}},
      {"1 0 0 0 0 1 0 0 0 0 1.1 0\n", {"poses.txt:1", "not a rotation", "0.001"}},
      {"1 0 0 0 0 1 0 0 0 0 -1 0\n", {"poses.txt:1", "determinant -1"}},
      {"1 2 3\n", {"poses.txt:1", "3 numbers"}},
      {"1 0 0 0\n0 1 0 0\n0 0 1 0\n", {"poses.txt:3", "4 x 4"}},
      {"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n", {"poses.txt:4", "0 0 0 1"}}};
  for (const auto& [text, words] : cases) {
    const std::string error = ErrorOf(text);
    for (const char* word : words)
      EXPECT_NE(error.find(word), std::string::npos) << "'" << error << "' lacks " << word;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

TEST(Poses, NearbyNeighboursAreInterpolatedAndFarOnesAreNot) {
  const RecordedPoses poses = ParsePoses("1 0 0 0 0 0 0 1\n1.08 8 0 0 0 0 0 1\n2 9 0 0 0 0 0 1\n", "a");
  EXPECT_NEAR(PoseNear(poses, 1.02, 0.1)->translation().x(), 2.0, 1e-9) << "between both";
  EXPECT_NEAR(PoseNear(poses, 1.02, 0.05)->translation().x(), 0.0, 1e-9) << "the later one is too far";
  EXPECT_NEAR(PoseNear(poses, 1.98, 0.05)->translation().x(), 9.0, 1e-9);
  EXPECT_NEAR(PoseNear(poses, 0.96, 0.05)->translation().x(), 0.0, 1e-9);
  EXPECT_NEAR(PoseNear(poses, 1.08, 0.0)->translation().x(), 8.0, 1e-9);
  EXPECT_FALSE(PoseNear(poses, 1.5, 0.05));
  EXPECT_FALSE(PoseNear(poses, 0.9, 0.05));
  EXPECT_FALSE(PoseNear(poses, 2.1, 0.05));
}

TEST(Poses, KittiCalibrationTurnsCameraPosesIntoThoseOfTheLidar) {
  // Camera: x right, y down, z forward, 0.3 m in front of the LiDAR. It drives 5 m forward.
  const Calibration calibration =
      ParseCalibration("P0: 7 0 6 0 0 7 1 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 -0.3\n", "calib.txt");
  EXPECT_TRUE(calibration.is_kitti);
  RecordedPoses poses = ParsePoses("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 5\n", "poses.txt");
  Apply(calibration, &poses);
  EXPECT_TRUE(poses.T_map_lidar[0].matrix().isIdentity(1e-9));
  EXPECT_LT((poses.T_map_lidar[1].translation() - Vec3(5, 0, 0)).norm(), 1e-9);
  EXPECT_TRUE(poses.T_map_lidar[1].linear().isIdentity(1e-9));
}

TEST(Poses, ACalibrationIsTheLidarInTheFrameOfThePoses) {
  const Calibration calibration = ParseCalibration("0.2 0 1 0 0 0 1\n", "lidar.txt");
  RecordedPoses poses = ParsePoses("1 0 0 0 0 0 0.70710678118 0.70710678118\n", "p.tum");
  Apply(calibration, &poses);
  EXPECT_LT((poses.T_map_lidar[0].translation() - Vec3(0, 0.2, 1)).norm(), 1e-9);
  EXPECT_THROW(ParseCalibration("1 0 0 0 0 0 0 1\n", "p.tum"), core::InputError)
      << "a time has no place there";
}

TEST(Poses, WrittenTumReadsBack) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "io_poses" / "p.tum";
  std::vector<core::StampedPose> poses;
  for (int i = 0; i < 5; ++i) {
    poses.push_back({1583840211.1 + 0.005 * i,
                     core::MakePose(core::RotationFromYawPitchRoll(i, 0.3, -0.2), Vec3(i, 2, 3))});
  }
  WriteTum(path, poses);
  const RecordedPoses read = ReadPoses(path);
  ASSERT_EQ(read.size(), poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(read.time_s[i], poses[i].time_s, 1e-6);
    EXPECT_TRUE(read.T_map_lidar[i].isApprox(poses[i].T, 1e-8));
  }
}

}  // namespace
}  // namespace atlas::mapping
