#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/cloud_writer.h"
#include "mapping/io/recorded_log.h"
#include "mapping/io/recorded_poses.h"
#include "mapping/io/scan_source.h"
#include "tests/support/recorded_scans.h"
#include "tests/support/shared_data.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::ReturnKind;
using core::Vec3;

class RecordedLogTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / "io_recorded_log" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
  }
  void Write(const std::string& name, const std::string& content) {
    core::WriteFileAtomically(folder_ / name, content);
  }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string ErrorOf(const RecordedLogOptions& options) {
    try {
      RecordedLog log(options);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

/// A cloud of one point, which tells which it is.
std::string Single(double x) {
  RecordedCloud cloud;
  cloud.rows = cloud.columns = 1;
  cloud.p_lidar = {core::Vec3f(static_cast<float>(x), 0, 0)};
  return CloudToPcd(cloud, CloudEncoding::kAscii);
}

TEST(TimeInName, IsSeconds) {
  EXPECT_NEAR(*TimeInName("1583840211.123456789"), 1583840211.123456789, 1e-6);
  EXPECT_NEAR(*TimeInName("cloud_1583840211_000000500"), 1583840211.0000005, 1e-6);
  EXPECT_NEAR(*TimeInName("scan_1583840211123456789"), 1583840211.123456789, 1e-6);
  EXPECT_NEAR(*TimeInName("1583840211123456"), 1583840211.123456, 1e-6);
  EXPECT_NEAR(*TimeInName("1583840211123"), 1583840211.123, 1e-6);
  EXPECT_NEAR(*TimeInName("12.300000000"), 12.3, 1e-9);
  for (const char* name : {"000012", "scan7", "source", "", "part_3_12", "99999999999999999999999"})
    EXPECT_FALSE(TimeInName(name)) << name;
}

TEST(NaturalOrder, CountsByValue) {
  EXPECT_TRUE(NaturalLess("scan9", "scan10"));
  EXPECT_TRUE(NaturalLess("9.5.pcd", "10.1.pcd"));
  EXPECT_TRUE(NaturalLess("a", "b") && NaturalLess("a", "a1") && !NaturalLess("b", "a"));
  EXPECT_TRUE(NaturalLess("a01", "a1") != NaturalLess("a1", "a01"));
  EXPECT_FALSE(NaturalLess("x", "x"));
}

TEST_F(RecordedLogTest, NamesWithControlCharactersAreRefused) {
  Write("scans/1.0.pcd", Single(1));
  Write("scans/2\n.0.pcd", Single(2));
  RecordedLogOptions options;
  options.scans = Path("");
  EXPECT_NE(ErrorOf(options).find("scans: the name of a cloud: holds a control character: '2\\n.0.pcd'"),
            std::string::npos)
      << ErrorOf(options);
}

TEST_F(RecordedLogTest, ScansMeetPosesByTheTimeInTheirNames) {
  for (const double t : {99.5, 100.1, 100.25, 105.0}) Write(fmt::format("s/{:.3f}.pcd", t), Single(t));
  Write("poses.tum", "100 0 0 0 0 0 0 1\n100.12 12 0 0 0 0 0 1\n100.3 30 0 0 0 0 0 1\n");
  RecordedLogOptions options;
  options.scans = Path("s");
  options.poses = Path("poses.tum");
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 2u) << "the first and the last are far from any pose";
  EXPECT_EQ(log.scans_without_pose(), 2u);
  EXPECT_EQ(log.name(0), "100.100.pcd");
  EXPECT_NEAR(log.T_map_lidar(0).translation().x(), 12.0, 1e-9) << "one neighbour is near";
  EXPECT_NEAR(log.T_map_lidar(1).translation().x(), 30.0, 1e-9);
  options.max_dt_s = 0.11;
  EXPECT_NEAR(RecordedLog(options).T_map_lidar(0).translation().x(), 10.0, 1e-9) << "interpolated";
  Write("late.tum", "1000 0 0 0 0 0 0 1\n");
  options.poses = Path("late.tum");
  EXPECT_NE(ErrorOf(options).find("late.tum: no pose within 0.11 s"), std::string::npos) << ErrorOf(options);
}

TEST_F(RecordedLogTest, PosesThatLieAmongTheCloudsNeedNoNaming) {
  for (const int i : {1, 2}) Write(fmt::format("s/scan{}.pcd", i), Single(i));
  RecordedLogOptions options;
  options.scans = Path("s");
  EXPECT_NE(ErrorOf(options).find("nothing tells the poses of these 2 scans: give --poses"),
            std::string::npos)
      << ErrorOf(options);
  Write("s/poses.txt", "1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n");
  EXPECT_NEAR(RecordedLog(options).T_map_lidar(1).translation().x(), 2.0, 1e-9);
  Write("s/poses.tum", "5 7 0 0 0 0 0 1\n6 8 0 0 0 0 0 1\n");
  EXPECT_NEAR(RecordedLog(options).T_map_lidar(1).translation().x(), 8.0, 1e-9) << "TUM before KITTI";
  Write("given.txt", "1 0 0 3 0 1 0 0 0 0 1 0\n1 0 0 4 0 1 0 0 0 0 1 0\n");
  options.poses = Path("given.txt");
  EXPECT_NEAR(RecordedLog(options).T_map_lidar(1).translation().x(), 4.0, 1e-9)
      << "what is named comes first";
}

TEST_F(RecordedLogTest, ASingleScanStandsAtItsViewpoint) {
  RecordedCloud cloud;
  cloud.rows = cloud.columns = 1;
  cloud.p_lidar = {core::Vec3f(1, 0, 0)};
  Write("one.pcd", CloudToPcd(cloud, CloudEncoding::kAscii));
  RecordedLogOptions options;
  options.scans = Path("one.pcd");
  EXPECT_TRUE(RecordedLog(options).T_map_lidar(0).matrix().isIdentity(0.0));
  std::string moved = CloudToPcd(cloud, CloudEncoding::kAscii);
  const size_t at = moved.find("VIEWPOINT");
  moved.replace(at, moved.find('\n', at) - at, "VIEWPOINT 4 5 6 0 0 0 1");
  Write("one.pcd", moved);
  EXPECT_EQ(RecordedLog(options).T_map_lidar(0).translation(), Vec3(4, 5, 6));
}

TEST_F(RecordedLogTest, NamelessScansMeetPosesByOrderWhereTheCountsAgree) {
  for (const int i : {10, 9, 2}) Write(fmt::format("s/scan{}.pcd", i), Single(i));
  Write("kitti.txt", "1 0 0 2 0 1 0 0 0 0 1 0\n1 0 0 9 0 1 0 0 0 0 1 0\n1 0 0 10 0 1 0 0 0 0 1 0\n");
  Write("two.txt", "1 0 0 2 0 1 0 0 0 0 1 0\n1 0 0 9 0 1 0 0 0 0 1 0\n");
  RecordedLogOptions options;
  options.scans = Path("s");
  options.poses = Path("kitti.txt");
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const core::SpinEvent event = log.Read(i);
    EXPECT_FALSE(event.scan.organised());
    ASSERT_EQ(event.scan.size(), 1u);
    EXPECT_EQ(event.scan.columns, 1);
    EXPECT_NEAR(log.T_map_lidar(i).translation().x(), static_cast<double>(event.scan.range_m[0]), 1e-6);
    EXPECT_EQ(event.scan.direction_lidar[0], core::Vec3f(1, 0, 0));
    EXPECT_NEAR(event.scan.stamp_s, 0.1 * static_cast<double>(i), 1e-9);
  }
  options.poses = Path("two.txt");
  EXPECT_NE(ErrorOf(options).find("2 poses for 3 scans"), std::string::npos) << ErrorOf(options);
  options.poses = "";
  EXPECT_NE(ErrorOf(options).find("--poses"), std::string::npos) << ErrorOf(options);
  options.scans = Path("s/scan9.pcd");
  EXPECT_EQ(RecordedLog(options).size(), 1u) << "a single scan stands at the origin";
  options.scans = Path("s/scan*.pcd");
  options.poses = Path("kitti.txt");
  EXPECT_EQ(RecordedLog(options).size(), 3u);
  Write("s/other.bin", std::string(16, 'a'));
  options.scans = Path("s");
  EXPECT_NE(ErrorOf(options).find("several kinds"), std::string::npos) << ErrorOf(options);
  for (const char* missing : {"nowhere", "nowhere/*.pcd", "s/*.ply"}) {
    options.scans = Path(missing);
    EXPECT_NE(ErrorOf(options), "") << missing;
  }
}

TEST_F(RecordedLogTest, RelationsBetweenCloudsArePoses) {
  Write("source.pcd", Single(1));
  Write("target.pcd", Single(2));
  Write("T_target_source.txt", "0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n");
  RecordedLogOptions options;
  options.scans = folder_.string();
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 2u);
  EXPECT_LT((log.T_map_lidar(0) * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 1e-9);
  EXPECT_TRUE(log.T_map_lidar(1).matrix().isIdentity(0.0));
  if (const auto pair = tests::SharedData("scan_pair")) {
    options.scans = pair->string();
    const RecordedLog real(options);
    ASSERT_EQ(real.size(), 2u);
    EXPECT_NEAR(real.T_map_lidar(0).translation().x(), 0.488882, 1e-6);
    EXPECT_GT(real.Read(1).scan.size(), 60000u);
  }
}

/// A data set as `atlas record` writes it: a room seen while driving, each ray from its own place.
void WriteDrive(const fs::path& folder, const core::LidarModel& model, std::vector<core::LidarScan>* scans) {
  const core::Box3 room{Vec3(-6, -4, -2), Vec3(6, 4, 3)};
  std::vector<core::StampedPose> trajectory, poses;
  for (int i = 0; i <= 100; ++i)
    trajectory.push_back({100.0 + 0.005 * i, core::PoseFromXyzYaw(Vec3(0.01 * i, 0, 0), 0.02 * i)});
  core::PoseTrajectory T_map_lidar;
  for (const auto& pose : trajectory) T_map_lidar.Add(pose.time_s, pose.T);
  for (const double stamp : {100.1, 100.3}) {
    core::LidarScan scan;
    scan.stamp_s = stamp;
    scan.rows = model.rows();
    scan.columns = model.columns;
    for (int row = 0; row < scan.rows; ++row) {
      for (int column = 0; column < scan.columns; ++column) {
        const double time = 0.1 * column / scan.columns;
        const core::Pose T = T_map_lidar.At(stamp + time);
        const Vec3 direction = model.Direction(row, column);
        const bool is_void = (row + column) % 5 == 0, dropout = (row + column) % 7 == 0;
        scan.kind.push_back(is_void ? ReturnKind::kVoid : dropout ? ReturnKind::kDropout : ReturnKind::kHit);
        const double range = room.Clip(T.translation(), T.linear() * direction)->second;
        scan.range_m.push_back(scan.kind.back() == ReturnKind::kHit ? static_cast<float>(range) : 0.0f);
        scan.direction_lidar.push_back(direction.cast<float>());
        scan.time_s.push_back(static_cast<float>(time));
      }
    }
    WriteScan(folder, scan);
    poses.push_back({stamp, T_map_lidar.At(stamp)});
    scans->push_back(std::move(scan));
  }
  WriteTum(folder / "poses.tum", poses);
  WriteTum(folder / "trajectory.tum", trajectory);
}

TEST_F(RecordedLogTest, ARecordedDataSetReplaysRayForRay) {
  const core::LidarModel model = core::FindLidarModel("os1_64");
  std::vector<core::LidarScan> scans;
  WriteDrive(folder_, model, &scans);
  Write("dataset.yaml", "lidar: os1_64\nmin_range_m: 0.5\nmax_range_m: 90\nscans: 2\n");
  RecordedLogOptions options;
  options.scans = folder_.string();
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 2u);
  ASSERT_TRUE(log.beams());
  const core::Box3 room{Vec3(-6, -4, -2), Vec3(6, 4, 3)};
  for (size_t s = 0; s < 2; ++s) {
    const core::SpinEvent event = log.Read(s);
    const core::LidarScan &got = event.scan, &want = scans[s];
    ASSERT_TRUE(got.rows == want.rows && got.columns == want.columns);
    EXPECT_EQ(got.kind, want.kind);
    EXPECT_EQ(got.time_s, want.time_s);
    EXPECT_NEAR(got.stamp_s, want.stamp_s, 1e-9);
    EXPECT_FLOAT_EQ(got.max_range_m, 90.0f);
    EXPECT_FLOAT_EQ(got.min_range_m, 0.5f);
    EXPECT_GT(event.T_odom_lidar.poses().size(), 10u);
    double worst_direction = 0.0, worst_wall = 0.0;
    for (size_t i = 0; i < got.size(); ++i) {
      ASSERT_NEAR(got.range_m[i], want.range_m[i], 1e-5f);
      worst_direction = std::max(
          worst_direction, static_cast<double>((got.direction_lidar[i] - want.direction_lidar[i]).norm()));
      if (got.kind[i] != ReturnKind::kHit) continue;
      const core::Pose T = event.T_odom_lidar.At(got.stamp_s + static_cast<double>(got.time_s[i]));
      const Vec3 p = T * (got.range_m[i] * got.direction_lidar[i]).cast<double>();
      const double wall =
          std::min((p - room.min).cwiseAbs().minCoeff(), (p - room.max).cwiseAbs().minCoeff());
      worst_wall = std::max(worst_wall, wall);
    }
    EXPECT_LT(core::Degrees(worst_direction), 0.01) << "also where nothing returned";
    EXPECT_LT(worst_wall, 1e-4) << "undistorted points lie on the walls";
  }
}

TEST_F(RecordedLogTest, WithoutATrajectoryAScanHasOnePose) {
  std::vector<core::LidarScan> scans;
  WriteDrive(folder_, core::FindLidarModel("vlp16"), &scans);
  fs::remove(folder_ / "trajectory.tum");
  RecordedLogOptions options;
  options.scans = folder_.string();
  const RecordedLog log(options);
  EXPECT_EQ(log.Read(0).T_odom_lidar.poses().size(), 1u);
  EXPECT_EQ(log.beams()->model.name, "estimated");
}

TEST_F(RecordedLogTest, WhatNoReturnMeansIsTheCallersWordWhereTheFileIsSilent) {
  tests::DriverQuirks quirks;
  quirks.missing = 0.2;
  const core::LidarModel model = tests::Presented(core::FindLidarModel("vlp16"), quirks);
  const RecordedCloud cloud = tests::RoomCloud(model, quirks, 3);
  Write("a.pcd", CloudToPcd(cloud, CloudEncoding::kBinaryCompressed));
  RecordedLogOptions options;
  options.scans = Path("a.pcd");
  options.min_range_m = 2.5;
  options.max_range_m = 6.0;
  for (const ReturnKind no_return : {ReturnKind::kDropout, ReturnKind::kVoid}) {
    options.no_return = no_return;
    const core::LidarScan scan = RecordedLog(options).Read(0).scan;
    ASSERT_EQ(scan.size(), cloud.size());
    for (size_t i = 0; i < scan.size(); ++i) {
      const float range = cloud.p_lidar[i].norm();
      const ReturnKind expected = std::isnan(range) ? no_return
                                  : range < 2.5f    ? ReturnKind::kDropout
                                  : range > 6.0f    ? ReturnKind::kVoid
                                                    : ReturnKind::kHit;
      ASSERT_EQ(scan.kind[i], expected);
      ASSERT_NEAR(scan.direction_lidar[i].norm(), 1.0f, 1e-5f);
    }
  }
  options.lidar = "none";
  const core::LidarScan rays = RecordedLog(options).Read(0).scan;
  EXPECT_EQ(rays.rows, 0);
  EXPECT_EQ(static_cast<size_t>(rays.columns), rays.size());
  EXPECT_LT(rays.size(), cloud.size());
  options.lidar = "vlp-16";
  EXPECT_NE(ErrorOf(options).find("vlp16"), std::string::npos);
  options.lidar = "os1_64";
  EXPECT_NE(ErrorOf(options).find("16 rows"), std::string::npos) << ErrorOf(options);
}

TEST_F(RecordedLogTest, FiringsInRowsAreTurnedToColumns) {
  const tests::DriverQuirks quirks;
  const core::LidarModel model = tests::Presented(core::FindLidarModel("vlp16"), quirks);
  const RecordedCloud cloud = tests::RoomCloud(model, quirks, 3);
  RecordedCloud turned = cloud;
  std::swap(turned.rows, turned.columns);
  for (int r = 0; r < cloud.rows; ++r) {
    for (int c = 0; c < cloud.columns; ++c)
      turned.p_lidar[static_cast<size_t>(c * cloud.rows + r)] =
          cloud.p_lidar[static_cast<size_t>(r * cloud.columns + c)];
  }
  Write("a.pcd", CloudToPcd(turned, CloudEncoding::kBinary));
  RecordedLogOptions options;
  options.scans = Path("a.pcd");
  const core::LidarScan scan = RecordedLog(options).Read(0).scan;
  EXPECT_EQ(scan.rows, 16);
  EXPECT_NEAR(scan.range_m[1234], cloud.p_lidar[1234].norm(), 1e-5f);
}

}  // namespace
}  // namespace atlas::mapping
