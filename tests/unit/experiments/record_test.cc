#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/record/dataset_writer.h"
#include "experiments/record/truth_seen.h"
#include "mapping/io/recorded_log.h"
#include "scenes/build/scene_builder.h"

namespace atlas::experiments {
namespace {

using core::ReturnKind;
using core::Vec3;

/// A room whose inner faces are x = +-5, y = +-4, z = 0 and z = 3, and a way of 4 m through it.
constexpr double kHalfX_m = 5.0, kHalfY_m = 4.0, kHeight_m = 3.0;

class RecordTest : public ::testing::Test {
 protected:
  RecordTest()
      : folder_(std::filesystem::path(::testing::TempDir()) / ("record_" + std::to_string(getpid()))) {
    std::string scene =
        "spawn: {x: 0, y: 0}\nground: {size: [12, 12]}\nobject_box: {min: [-5, -4, 0], max: [5, 4, "
        "3]}\nparts:\n";
    for (const char* box :
         {"size: [1, 10, 4], pose: {xyz: [5.5, 0, 1.5]}", "size: [1, 10, 4], pose: {xyz: [-5.5, 0, 1.5]}",
          "size: [12, 1, 4], pose: {xyz: [0, 4.5, 1.5]}", "size: [12, 1, 4], pose: {xyz: [0, -4.5, 1.5]}",
          "size: [12, 10, 1], pose: {xyz: [0, 0, 3.5]}"}) {
      scene += std::string("  - {primitive: box, ") + box + "}\n";
    }
    core::WriteFileAtomically(folder_ / "room.yaml", scene);
    Route("{at: [-2, -1, 1]}", "{at: [0, 0.5, 1.2]}", "{at: [2, 0, 1]}");
    options_.scene = (folder_ / "room.yaml").string();
    options_.route = folder_ / "route.yaml";
    options_.lidar = "vlp16";
    options_.noise = false;
  }
  ~RecordTest() override { std::filesystem::remove_all(folder_); }

  void Route(const std::string& a, const std::string& b, const std::string& c, const std::string& head = "") {
    core::WriteFileAtomically(folder_ / "route.yaml",
                              head +
                                  "speed_m_s: 1.0\nscans: 5\nsway: {roll_deg: 8, pitch_deg: 5, yaw_deg: 10, "
                                  "bob_m: 0.05, step_hz: 2}\nwaypoints:\n  - " +
                                  a + "\n  - " + b + "\n  - " + c + "\n");
  }

  std::string Error() {
    try {
      DatasetRecorder recorder(options_);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
  RecordOptions options_;
};

/// Distance from inside the room to its walls along a ray.
double RoomDistance(const Vec3& origin, const Vec3& direction) {
  const core::Box3 room{Vec3(-kHalfX_m, -kHalfY_m, 0), Vec3(kHalfX_m, kHalfY_m, kHeight_m)};
  double least = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const double face = direction[axis] > 0 ? room.max[axis] : room.min[axis];
    least = std::min(least, (face - origin[axis]) / direction[axis]);
  }
  return least;
}

TEST_F(RecordTest, RangesAreTheDistanceToTheWallFromEachRaysOwnPose) {
  DatasetRecorder recorder(options_);
  core::SpinEvent spin;
  size_t rays = 0;
  double moved = 0.0;
  while (recorder.Next(&spin)) {
    const core::LidarScan& scan = spin.scan;
    for (size_t i = 0; i < scan.size(); i += 7) {
      ASSERT_EQ(scan.kind[i], ReturnKind::kHit);
      const core::Pose T = spin.T_odom_lidar.At(scan.stamp_s + scan.time_s[i]);
      const Vec3 direction = T.linear() * scan.direction_lidar[i].cast<double>();
      ASSERT_NEAR(scan.range_m[i], RoomDistance(T.translation(), direction), 2e-4);
      ++rays;
    }
    const core::Pose first = spin.T_odom_lidar.At(scan.stamp_s),
                     last = spin.T_odom_lidar.At(scan.stamp_s + 0.0999);
    moved = std::max(moved, (last.translation() - first.translation()).norm());
  }
  EXPECT_GT(rays, 5u * 16u * 1800u / 8u);
  EXPECT_GT(moved, 0.05);  // so that one pose a scan would have failed
}

TEST_F(RecordTest, StampsAndTimesAscendAndPosesAreThoseOfTheTrajectory) {
  DatasetRecorder recorder(options_);
  ASSERT_EQ(recorder.stamps_s().size(), 5u);
  const double duration_s = recorder.trajectory().poses().back().time_s;
  EXPECT_NEAR(recorder.stamps_s().back(), duration_s - 0.1, 1e-6);
  core::SpinEvent spin;
  double before_s = -1.0;
  while (recorder.Next(&spin)) {
    EXPECT_GT(spin.scan.stamp_s, before_s);
    before_s = spin.scan.stamp_s;
    for (int c = 1; c < spin.scan.columns; ++c) ASSERT_GT(spin.scan.time_s[c], spin.scan.time_s[c - 1]);
    EXPECT_LT(spin.scan.time_s[spin.scan.columns - 1], 0.1f);
    EXPECT_EQ(spin.scan.time_s[3], spin.scan.time_s[static_cast<size_t>(spin.scan.columns) + 3]);
    for (double after_s : {0.0, 0.033, 0.0999}) {
      const core::Pose a = spin.T_odom_lidar.At(spin.scan.stamp_s + after_s),
                       b = recorder.trajectory().At(spin.scan.stamp_s + after_s);
      EXPECT_LT((a.matrix() - b.matrix()).norm(), 1e-12);
    }
  }
  const auto& poses = recorder.trajectory().poses();
  EXPECT_LT((poses.front().T.translation() - Vec3(-2, -1, 1)).norm(), 0.08);
  EXPECT_LT((poses.back().T.translation() - Vec3(2, 0, 1)).norm(), 0.08);
  for (size_t i = 1; i < poses.size(); ++i) {
    ASSERT_LE(poses[i].time_s - poses[i - 1].time_s, 0.01);
    ASSERT_LT((poses[i].T.translation() - poses[i - 1].T.translation()).norm(), 0.03);
  }
}

TEST_F(RecordTest, NeitherThreadsNorRewindingChangesAScan) {
  options_.noise = true;
  options_.scans = 2;
  const auto record = [&](int threads) {
    options_.threads = threads;
    DatasetRecorder recorder(options_);
    core::SpinEvent first, second, again;
    EXPECT_TRUE(recorder.Next(&first) && recorder.Next(&second));
    EXPECT_FALSE(recorder.Next(&again));
    recorder.Rewind();
    EXPECT_TRUE(recorder.Next(&again));
    EXPECT_EQ(first.scan.range_m, again.scan.range_m);
    EXPECT_NE(first.scan.range_m, second.scan.range_m);
    return second.scan.range_m;
  };
  EXPECT_EQ(record(1), record(3));
}

TEST_F(RecordTest, ADataSetReadsBackAsWhatWasRecorded) {
  options_.noise = true;  // so that there are dropouts
  DatasetRecorder recorder(options_);
  const DatasetCounts counts =
      WriteDataset(&recorder, folder_ / "set", 0.1, [](size_t, size_t) { return true; });
  EXPECT_EQ(counts.scans, 5u);
  EXPECT_GT(counts.dropouts, 0u);
  EXPECT_GT(counts.truth_points, 1000u);
  mapping::RecordedLogOptions from;
  from.scans = (folder_ / "set").string();
  const mapping::RecordedLog log(from);
  ASSERT_EQ(log.size(), 5u);
  recorder.Rewind();
  core::SpinEvent spin;
  for (size_t k = 0; recorder.Next(&spin); ++k) {
    const core::SpinEvent read = log.Read(k);
    EXPECT_NEAR(read.scan.stamp_s, spin.scan.stamp_s, 1e-9);
    ASSERT_EQ(read.scan.kind, spin.scan.kind);
    for (size_t i = 0; i < spin.scan.size(); i += 13) {
      ASSERT_NEAR(read.scan.range_m[i], spin.scan.range_m[i], 1e-5);
      ASSERT_NEAR(read.scan.time_s[i], spin.scan.time_s[i], 1e-7);
      ASSERT_LT((read.scan.direction_lidar[i] - spin.scan.direction_lidar[i]).norm(), 2e-3f);
      const core::Pose a = read.T_odom_lidar.At(spin.scan.stamp_s + spin.scan.time_s[i]),
                       b = spin.T_odom_lidar.At(spin.scan.stamp_s + spin.scan.time_s[i]);
      ASSERT_LT((a.matrix() - b.matrix()).norm(), 1e-5);
    }
  }
  EXPECT_THROW(WriteDataset(&recorder, folder_ / "set", 0.0, [](size_t, size_t) { return true; }),
               core::InputError);
}

TEST_F(RecordTest, ADataSetKeepsWhatItIsRecordedAgainFrom) {
  const auto record = [](const RecordOptions& options, const std::filesystem::path& folder) {
    DatasetRecorder recorder(options);
    WriteDataset(&recorder, folder, 0.0, [](size_t, size_t) { return true; });
  };
  record(options_, folder_ / "set");
  std::filesystem::remove(folder_ / "room.yaml");
  std::filesystem::remove(folder_ / "route.yaml");
  options_.scene = (folder_ / "set/scene/room.yaml").string();
  options_.route = folder_ / "set/route.yaml";
  record(options_, folder_ / "again");
  size_t scans = 0;
  for (const auto& scan : std::filesystem::directory_iterator(folder_ / "set/scans")) {
    ++scans;
    EXPECT_TRUE(core::ReadFile(scan.path()) ==
                core::ReadFile(folder_ / "again/scans" / scan.path().filename()));
  }
  EXPECT_EQ(scans, 5u);
  EXPECT_EQ(core::ReadFile(folder_ / "again/dataset.yaml"), core::ReadFile(folder_ / "set/dataset.yaml"));
}

TEST_F(RecordTest, StoppingLeavesWholeFilesOnly) {
  DatasetRecorder recorder(options_);
  const DatasetCounts counts =
      WriteDataset(&recorder, folder_ / "set", 0.1, [](size_t done, size_t) { return done < 2; });
  EXPECT_TRUE(counts.interrupted);
  size_t scans = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder_ / "set" / "scans")) {
    EXPECT_EQ(file.path().extension(), ".pcd");
    ++scans;
  }
  EXPECT_EQ(scans, 2u);
  mapping::RecordedLogOptions from;
  from.scans = (folder_ / "set").string();
  EXPECT_EQ(mapping::RecordedLog(from).size(), 2u);
}

TEST_F(RecordTest, BadInputIsOneLineThatNamesIt) {
  const auto expect = [&](const std::string& says) {
    const std::string error = Error();
    EXPECT_NE(error.find(says), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  };
  const RecordOptions good = options_;
  options_.lidar = "os1_46";
  expect("did you mean 'os1_64'?");
  options_ = good;
  options_.scene = "campuss";
  expect("did you mean 'campus'?");
  options_ = good;
  options_.rate_hz = 25.0;
  expect("--rate 25");
  options_ = good;
  options_.scans = 1000;
  expect("--scans 1000");
  options_ = good;
  Route("{at: [-2, -1, 1]}", "{at: [30, 0, 1]}", "{at: [2, 0, 1]}");
  expect("waypoints[1].at: (30.00, 0.00) lies outside the scene");
  Route("{at: [-2, -1, 1]}", "{at: [0, 4.8, 1]}", "{at: [2, 0, 1]}");
  expect("passes through a surface");
  Route("{at: [-2, -1, 1]}", "{at: [-2, -1, 1]}", "{at: [2, 0, 1]}");
  expect("less than 5 cm");
  Route("{at: [-2, -1]}", "{at: [0, 0, 1]}", "{at: [2, 0, 1]}");
  expect("route.yaml:5: waypoints[0].at");
  Route("{at: [-2, -1, 1]}", "{at: [0, 0, 1]}", "{at: [2, 0, 1]}", "hieghts: map\n");
  expect("hieghts");
  options_.route = folder_ / "none.yaml";
  expect("none.yaml");
  options_ = good;
  options_.scene = "car";
  options_.route.clear();
  expect("scene car has no route of its own");
}

TEST(SeenPoints, AgreeWithTheShadowOfABoxOnAWall) {
  // Sensor at the origin, a plate from y = -1 to 1 at x = 2, a wall at x = 6: its shadow there is y = -3
  // to 3.
  scenes::SceneBuilder builder;
  const scenes::Paint paint{"wall", core::Label::kWall, true};
  builder.Box(paint, Vec3(6, -20, -20), Vec3(6.5, 20, 20));
  builder.Box(paint, Vec3(2, -1, -20), Vec3(2.1, 1, 20));
  const scenes::SceneSpec scene = builder.Finish({0, 0}, 0.0);
  sim::Raycaster raycaster(scene);
  raycaster.CommitPoses();
  const core::LidarModel lidar = core::FindLidarModel("vlp16");
  std::vector<core::Vec3f> points, normals;
  for (double y = -9.95; y < 10.0; y += 0.1) {
    for (double z : {-1.0, 0.0, 1.0, 4.0}) {
      points.push_back(Vec3(6, y, z).cast<float>());
      normals.push_back(-core::Vec3f::UnitX());
    }
    points.push_back(Vec3(6.5, y, 0).cast<float>());  // the wall's back
    normals.push_back(core::Vec3f::UnitX());
  }
  const auto seen = SeenPoints(points, normals, {{0.0, core::Pose::Identity()}}, lidar, raycaster, 2);
  for (size_t i = 0; i < points.size(); ++i) {
    const core::Vec3f& p = points[i];
    const bool in_fan = std::abs(p.z()) <= std::tan(core::Radians(15.0)) * std::hypot(p.x(), p.y());
    const bool expected = p.x() < 6.2f && std::abs(p.y()) > 3.0f && in_fan;
    EXPECT_EQ(seen[i] != 0, expected) << p.transpose();
  }
}

}  // namespace
}  // namespace atlas::experiments
