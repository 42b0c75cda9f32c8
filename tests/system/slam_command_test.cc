// `atlas slam` as a user meets it: a log without poses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/mesh.h"
#include "mapping/io/cloud_writer.h"
#include "mapping/io/recorded_poses.h"
#include "mapping/slam/g2o_file.h"
#include "tests/support/command_line.h"
#include "tests/support/recorded_scans.h"

namespace {

namespace fs = std::filesystem;
using atlas::core::Vec3;
using atlas::tests::Outcome;

class SlamCommand : public atlas::tests::CommandLine {
 protected:
  static constexpr int kScans = 30;

  /// A walk of 3.5 m through an empty room.
  static Vec3 At(int scan) {
    const double s = 0.12 * scan;
    return {s - 1.5, 0.4 * std::sin(s), 0.05 * std::sin(3.0 * s)};
  }
  void WriteLog() {
    atlas::core::LidarModel lidar = atlas::core::FindLidarModel("os0_64");
    atlas::tests::DriverQuirks quirks;
    quirks.point_noise_m = 0.01;
    for (int i = 0; i < kScans; ++i) {
      const auto cloud = atlas::tests::RoomCloud(lidar, quirks, static_cast<uint64_t>(i), At(i));
      atlas::core::WriteFileAtomically(
          dir_ / "log" / "scans" / fmt::format("{:.1f}00.pcd", 100.0 + 0.1 * i),
          atlas::mapping::CloudToPcd(cloud, atlas::mapping::CloudEncoding::kBinaryCompressed));
    }
  }
  /// Odometry that is 5 % too long.
  void WriteOdometry(int scans) {
    std::string rows;
    for (int i = 0; i < scans; ++i)
      rows += fmt::format("{:.1f} {} {} {} 0 0 0 1\n", 100.0 + 0.1 * i, 1.05 * At(i).x(), 1.05 * At(i).y(),
                          1.05 * At(i).z());
    Write("odometry.tum", rows);
  }
  void ExpectTrajectory(const std::string& file) {
    const auto poses = atlas::mapping::ReadPoses(dir_ / file);
    ASSERT_EQ(poses.size(), static_cast<size_t>(kScans));
    for (int i = 0; i < kScans; ++i) {
      EXPECT_NEAR(poses.time_s[static_cast<size_t>(i)], 100.0 + 0.1 * i, 1e-6);
      const Vec3 moved =
          poses.T_map_lidar[static_cast<size_t>(i)].translation() - poses.T_map_lidar[0].translation();
      EXPECT_LT((moved - (At(i) - At(0))).norm(), 0.03) << file << " scan " << i;
    }
  }
};

TEST_F(SlamCommand, ALogWithoutPosesBecomesTrajectoryGraphAtlasAndMesh) {
  WriteLog();
  const Outcome outcome = Atlas("slam --scans log --resolution 0.2 --out out --set slam.node_spacing_m=1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.text;
  ExpectTrajectory("out/trajectory.txt");
  const auto graph = atlas::mapping::ReadG2o(dir_ / "out/graph.g2o");
  EXPECT_EQ(graph.graph.size(), 4u) << "a node a metre";
  EXPECT_TRUE(fs::exists(dir_ / "out/atlas/submaps.csv"));
  EXPECT_GT(fs::file_size(dir_ / "out/mesh.ply"), 10000u);
  const auto json = nlohmann::json::parse(atlas::core::ReadFile(dir_ / "out/summary.json"));
  EXPECT_EQ(json["status"], "completed");
  EXPECT_EQ(json["scans"], kScans);
  EXPECT_EQ(json["scans_lost"], 0);
  EXPECT_NEAR(json["way_m"].get<double>(), 3.6, 0.2);
  // A row of 22 numbers a scan, variances that grow from none at the first.
  std::istringstream rows(atlas::core::ReadFile(dir_ / "out/trajectory_covariance.txt"));
  std::vector<double> first_variance;
  for (std::string line; std::getline(rows, line);) {
    if (line[0] == '#') continue;
    std::istringstream numbers(line);
    std::vector<double> row;
    for (double x; numbers >> x;) row.push_back(x);
    ASSERT_EQ(row.size(), 22u);
    first_variance.push_back(row[1]);
  }
  ASSERT_EQ(first_variance.size(), static_cast<size_t>(kScans));
  EXPECT_EQ(first_variance.front(), 0.0);
  EXPECT_GT(first_variance.back(), 1e-6);
}

TEST_F(SlamCommand, TheUsersOdometryIsCorrected) {
  WriteLog();
  WriteOdometry(kScans);
  const Outcome outcome = Atlas("slam --scans log --odometry odometry.tum --resolution 0.2 --out out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.text;
  ExpectTrajectory("out/trajectory.txt");
}

TEST_F(SlamCommand, ThreadsChangeNoByte) {
  WriteLog();
  for (const char* threads : {"1", "3"}) {
    const Outcome outcome =
        Atlas(fmt::format("slam --scans log --limit 8 --resolution 0.2 --threads {0} --out out{0}", threads));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.text;
  }
  for (const char* file : {"trajectory.txt", "trajectory_covariance.txt", "graph.g2o", "mesh.ply"})
    EXPECT_EQ(atlas::core::ReadFile(dir_ / "out1" / file), atlas::core::ReadFile(dir_ / "out3" / file))
        << file;
}

TEST_F(SlamCommand, ASessionThatIsNotRecognisedWritesNothing) {
  WriteLog();
  ASSERT_EQ(Atlas("slam --scans log --resolution 0.2 --out out").exit_code, 0);
  // An empty room looks the same from both ends.
  const Outcome outcome = Atlas("slam --scans log --continue out --out again");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.text;
  EXPECT_NE(outcome.text.find("not recognised"), std::string::npos) << outcome.text;
  EXPECT_FALSE(fs::exists(dir_ / "again/atlas"));
  ExpectRefusal("slam --scans log --continue log --out again", {"log", "no saved atlas"});
  ExpectRefusal("slam --scans log --continue out --resolution 0.1 --out again",
                {"mapper.resolution_m", "0.1", "0.2"});
  fs::remove_all(dir_ / "out/atlas/slam");
  ExpectRefusal("slam --scans log --continue out --out again", {"out/atlas", "slam"});
}

TEST_F(SlamCommand, BadInputIsOneLine) {
  WriteLog();
  ExpectRefusal("map --scans log", {"--poses", "atlas slam"});
  ExpectRefusal("slam", {"--scans"});
  ExpectRefusal("slam --scans nowhere", {"nowhere"});
  const std::string first = "log/scans/100.000.pcd";
  ExpectRefusal("slam --scans " + first + " --out one", {first, "one scan"});
  ExpectRefusal("slam --scans log --odometry none.tum", {"none.tum", "no such file"});
  Write("untimed.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  ExpectRefusal("slam --scans log --odometry untimed.txt", {"untimed.txt", "times"});
  ExpectRefusal("slam --scans log --set slam.loop_overlap=7", {"slam.loop_overlap", "7"});
  ExpectRefusal("slam --scans log --set mapper.name=octomap", {"mapper.name", "atlas"});
  Write("odometry.tum", "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n");
  ExpectRefusal("slam --scans log --odometry odometry.tum", {"odometry.tum", "100.000"});
}

}  // namespace
