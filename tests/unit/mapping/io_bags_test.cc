#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/bag_source.h"
#include "mapping/io/recorded_log.h"
#include "tests/support/bag_writer.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::Vec3;
using core::Vec3f;
using tests::BagWriter;

/// tests/data/ros_bags/make_bags.cc tells what is in them.
std::string BagOfRos(const std::string& compression) {
  return core::InstalledFile("tests/data/ros_bags/" + compression + ".bag").string();
}

class BagsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / "io_bags" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
  }
  std::string Write(const std::string& bytes) {
    core::WriteFileAtomically(folder_ / "a.bag", bytes);
    return (folder_ / "a.bag").string();
  }
  /// The line with which a log is refused.
  static std::string ErrorOf(const std::string& scans, const std::string& poses = "") {
    RecordedLogOptions options;
    options.scans = scans;
    options.poses = poses;
    try {
      const RecordedLog log(options);
      for (size_t i = 0; i < log.size(); ++i) log.Read(i);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

class BagsOfRos : public ::testing::TestWithParam<const char*> {};

TEST_P(BagsOfRos, OrganisedCloudsHaveTheirPointsTimesAndRings) {
  const auto source = OpenBag(BagOfRos(GetParam()), "/points");
  ASSERT_EQ(source->entries().size(), 3u);
  EXPECT_EQ(source->frame(), "lidar");
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(*source->entries()[static_cast<size_t>(k)].stamp_s, 1600000000.5 + k, 1e-6);
    const RecordedCloud cloud = source->Read(static_cast<size_t>(k));
    ASSERT_TRUE(cloud.organised);
    ASSERT_EQ(cloud.rows, 2);
    ASSERT_EQ(cloud.columns, 5);
    for (size_t i = 0; i < 10; ++i) {
      const float row = i < 5 ? 0.0f : 1.0f;
      EXPECT_NEAR(cloud.time_s[i], 0.02f * static_cast<float>(i % 5), 1e-7f);
      EXPECT_EQ(cloud.ring[i], i / 5);
      if (i % 4 == 0) {
        EXPECT_TRUE(std::isnan(cloud.p_lidar[i].x()));
      } else {
        EXPECT_EQ(cloud.p_lidar[i], Vec3f(static_cast<float>(i) + 1.0f, 10.0f * static_cast<float>(k), row));
      }
    }
  }
}

TEST_P(BagsOfRos, DoublesInBigEndianAreTheSameNumbers) {
  const auto source = OpenBag(BagOfRos(GetParam()), "dense");
  ASSERT_EQ(source->entries().size(), 2u);
  for (size_t k = 0; k < 2; ++k) {
    const RecordedCloud cloud = source->Read(k);
    ASSERT_FALSE(cloud.organised);
    ASSERT_EQ(cloud.size(), 7u);
    EXPECT_TRUE(std::isnan(cloud.p_lidar[0].x()) == (k == 0)) << "the origin itself is no return";
    for (size_t i = 1; i < 7; ++i) {
      const auto x = static_cast<float>(i);
      EXPECT_EQ(cloud.p_lidar[i], Vec3f(x, -x, 0.25f * static_cast<float>(k)));
    }
  }
}

TEST_P(BagsOfRos, PosesOfTheBaseBecomeThoseOfTheLidarByTheStaticTransforms) {
  const RecordedPoses poses = ReadBagPoses(BagOfRos(GetParam()), "/odom", "lidar");
  ASSERT_EQ(poses.size(), 3u);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(poses.time_s[k], 1600000000.5 + static_cast<double>(k), 1e-6) << "the header's, not recorded";
    EXPECT_LT((poses.T_map_lidar[k].translation() - Vec3(2.0 * static_cast<double>(k) + 0.3, 0, 0)).norm(),
              1e-12);
    EXPECT_LT((poses.T_map_lidar[k].linear() * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-12);
  }
  EXPECT_NE(poses.note.find("from base_link to lidar"), std::string::npos) << poses.note;
  EXPECT_NEAR(ReadBagPoses(BagOfRos(GetParam()), "", "").T_map_lidar[1].translation().x(), 2.0, 1e-12);
  const RecordedPoses strange = ReadBagPoses(BagOfRos(GetParam()), "", "camera");
  EXPECT_NEAR(strange.T_map_lidar[1].translation().x(), 2.0, 1e-12);
  EXPECT_NE(strange.note.find("--calib"), std::string::npos) << strange.note;
}

TEST_P(BagsOfRos, AreLogsWithoutAnotherWord) {
  RecordedLogOptions options;
  options.scans = BagOfRos(GetParam()) + ":/dense";
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 2u);
  EXPECT_NEAR(log.T_map_lidar(1).translation().x(), 2.3, 1e-12);
  const core::SpinEvent event = log.Read(1);
  EXPECT_NEAR(event.scan.stamp_s, 1600000001.5, 1e-6);
  EXPECT_EQ(event.scan.size(), 7u);
  EXPECT_NE(log.Describe().find("/odom by time (from base_link to lidar by /tf_static)"), std::string::npos)
      << log.Describe();
}

TEST_P(BagsOfRos, EachRayLeavesFromItsOwnPlaceAlongATopicOfPoses) {
  RecordedLogOptions options;
  options.scans = BagOfRos(GetParam()) + ":/points";
  options.trajectory = BagOfRos(GetParam()) + ":/odom";
  options.lidar = "none";
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 3u);
  const core::SpinEvent event = log.Read(1);
  for (const double t : {0.0, 0.04, 0.08})  // 2 m in the second from scan to scan
    EXPECT_NEAR(event.T_odom_lidar.At(event.scan.stamp_s + t).translation().x(), 2.3 + 2.0 * t, 1e-5);
  EXPECT_NEAR(static_cast<double>(*std::max_element(event.scan.time_s.begin(), event.scan.time_s.end())),
              0.08, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Compressions, BagsOfRos, ::testing::Values("none", "bz2", "lz4"),
                         [](const auto& info) { return std::string(info.param); });

TEST_F(BagsTest, TopicsAreNamedWhereThereIsAChoice) {
  const std::string none = BagOfRos("none");
  EXPECT_NE(ErrorOf(none).find("2 topics with sensor_msgs/PointCloud2; name one"), std::string::npos)
      << ErrorOf(none);
  EXPECT_NE(ErrorOf(none + ":/pints").find("did you mean '/points'"), std::string::npos)
      << ErrorOf(none + ":/pints");
  EXPECT_NE(ErrorOf(none + ":/odom").find("/odom holds nav_msgs/Odometry"), std::string::npos);
  EXPECT_NE(ErrorOf(none + ":/dense", none + ":/points").find("not poses"), std::string::npos);
  BagWriter writer;
  writer.Add("/imu", "sensor_msgs/Imu", 1, "x");
  const std::string bag = Write(writer.Bytes());
  EXPECT_NE(ErrorOf(bag).find("no topic with sensor_msgs/PointCloud2 (topics: /imu)"), std::string::npos)
      << ErrorOf(bag);
}

/// Clouds at 1 s and 2 s.
BagWriter TwoClouds() {
  BagWriter writer;
  for (uint32_t s = 1; s < 3; ++s) {
    writer.Add("/p", "sensor_msgs/PointCloud2", s,
               tests::CloudMessage(s, 1, 2, {1, 2, 3, static_cast<float>(s), 0, 0}));
  }
  return writer;
}

TEST_F(BagsTest, EachKindOfPoseMessageIsRead) {
  using tests::BagHeaderBytes, tests::PoseBytes, tests::Raw, tests::Sized;
  const std::string covariance(36 * 8, '\0');
  const auto check = [&](const std::string& type, const std::function<std::string(uint32_t)>& message) {
    BagWriter writer = TwoClouds();
    for (uint32_t s = 1; s < 3; ++s) writer.Add("/pose", type, s, message(s));
    RecordedLogOptions options;
    options.scans = Write(writer.Bytes());
    const RecordedLog log(options);
    ASSERT_EQ(log.size(), 2u) << type;
    for (size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(log.T_map_lidar(i).translation(), Vec3(5.0 * static_cast<double>(i + 1), 0, 0)) << type;
      EXPECT_EQ(log.Read(i).scan.size(), 2u);
    }
  };
  const auto stamped = [&](uint32_t s) { return BagHeaderBytes(s, "map") + PoseBytes(5.0 * s); };
  check("geometry_msgs/PoseStamped", stamped);
  check("geometry_msgs/PoseWithCovarianceStamped", [&](uint32_t s) { return stamped(s) + covariance; });
  check("geometry_msgs/TransformStamped",
        [&](uint32_t s) { return BagHeaderBytes(s, "map") + Sized("lidar") + PoseBytes(5.0 * s); });
  check("nav_msgs/Odometry", [&](uint32_t s) {
    return BagHeaderBytes(s, "map") + Sized("") + PoseBytes(5.0 * s) + covariance + covariance;
  });
  check("nav_msgs/Path", [&](uint32_t s) {  // the second path has both poses
    std::string path = BagHeaderBytes(s, "map") + Raw(s);
    for (uint32_t i = 1; i <= s; ++i) path += stamped(i);
    return path;
  });
}

TEST_F(BagsTest, TransformsGiveThePosesOfTheCloudsFrame) {
  using tests::BagHeaderBytes, tests::PoseBytes, tests::Raw, tests::Sized;
  const auto transform = [](uint32_t s, const std::string& parent, const std::string& child, double x) {
    return BagHeaderBytes(s, parent) + Sized(child) + PoseBytes(x);
  };
  BagWriter writer = TwoClouds();
  const std::string type = "tf2_msgs/TFMessage";
  writer.Add("/tf_static", type, 1, Raw(uint32_t{1}) + transform(0, "base", "/lidar", 0.25));
  for (uint32_t s = 1; s < 3; ++s)
    writer.Add("/tf", type, s, Raw(uint32_t{1}) + transform(s, "odom", "base", 5.0 * s));
  writer.Add("/tf", type, 1,
             Raw(uint32_t{2}) + transform(1, "map", "odom", 100) + transform(1, "base", "leg", 9));
  RecordedLogOptions options;
  options.scans = Write(writer.Bytes());
  options.poses = options.scans + ":/tf";
  const RecordedLog log(options);
  ASSERT_EQ(log.size(), 2u);
  EXPECT_EQ(log.T_map_lidar(0).translation(), Vec3(105.25, 0, 0));
  EXPECT_EQ(log.T_map_lidar(1).translation(), Vec3(110.25, 0, 0));
  EXPECT_NE(log.Describe().find("(lidar in map)"), std::string::npos) << log.Describe();
  BagWriter still = TwoClouds();
  still.Add("/tf", type, 1, Raw(uint32_t{1}) + transform(1, "base", "leg", 9));
  const std::string bag = Write(still.Bytes());
  EXPECT_NE(ErrorOf(bag, bag + ":/tf").find("no transform moves the clouds' frame 'lidar'"),
            std::string::npos);
  BagWriter round = TwoClouds();
  round.Add("/tf", type, 1, Raw(uint32_t{2}) + transform(1, "a", "lidar", 1) + transform(1, "lidar", "a", 1));
  const std::string ring = Write(round.Bytes());
  EXPECT_NE(ErrorOf(ring, ring + ":/tf").find("go round"), std::string::npos) << ErrorOf(ring, ring + ":/tf");
}

TEST_F(BagsTest, DamageIsToldInALine) {
  const std::string whole = TwoClouds().Bytes();
  const auto error_of = [&](const std::string& bytes) { return ErrorOf(Write(bytes)); };
  EXPECT_NE(error_of(TwoClouds().Bytes(false)).find("rosbag reindex"), std::string::npos);
  std::string older = whole;
  older[9] = '1';
  EXPECT_NE(error_of(older).find("format 1.0 of ROS bags (2.0 is read here"), std::string::npos)
      << error_of(older);
  EXPECT_NE(error_of("not a bag").find("not a ROS 1 bag"), std::string::npos);
  EXPECT_NE(error_of("").find("not a ROS 1 bag"), std::string::npos);
  for (size_t cut = 1; cut < whole.size(); cut += 7) {
    const std::string error = error_of(whole.substr(0, cut));
    EXPECT_NE(error.find("a.bag: "), std::string::npos) << cut << " bytes: " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
  for (const char* compression : {"bz2", "lz4"}) {
    std::string packed = core::ReadFile(BagOfRos(compression));
    const size_t chunk = packed.find("compression=");
    for (size_t i = 0; i < 40; ++i) packed[chunk + 60 + i] = '\xff';
    const std::string bag = Write(packed), error = ErrorOf(bag + ":/points", bag + ":/odom");
    EXPECT_NE(error.find(std::string(compression) + " data are damaged"), std::string::npos) << error;
  }
}

TEST_F(BagsTest, CloudsThatContradictThemselvesAreRefused) {
  const auto error_of = [&](uint32_t height, uint32_t width) {
    BagWriter writer;
    writer.Add("/p", "sensor_msgs/PointCloud2", 1, tests::CloudMessage(1, height, width, {1, 2, 3}));
    return ErrorOf(Write(writer.Bytes()));
  };
  EXPECT_EQ(error_of(1, 1), "");
  EXPECT_NE(error_of(1, 2).find("a.bag: /p[0]: 1 x 2 points need 32 bytes, the data have 16"),
            std::string::npos)
      << error_of(1, 2);
  EXPECT_NE(error_of(0x10000, 0x10000).find("65536 x 65536 points (limit"), std::string::npos);
  EXPECT_NE(error_of(0xffffffff, 1).find("(limit"), std::string::npos);
}

}  // namespace
}  // namespace atlas::mapping
