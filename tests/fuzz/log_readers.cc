#include <fmt/format.h>

#include <fstream>

#include "core/files.h"
#include "mapping/io/beam_table.h"
#include "mapping/io/cloud_writer.h"
#include "mapping/io/recorded_log.h"
#include "mapping/io/recorded_poses.h"
#include "mapping/io/scan_graph.h"
#include "tests/fuzz/fuzzed_reader.h"
#include "tests/support/bag_writer.h"
#include "tests/support/recorded_scans.h"

namespace atlas::fuzz {
namespace {

namespace fs = std::filesystem;
using mapping::CloudEncoding;
using mapping::RecordedCloud;

/// 6 x 24 points of a small LiDAR, with times and kinds.
RecordedCloud SmallCloud(uint64_t seed) {
  core::LidarModel model = core::FindLidarModel("vlp16");
  model.elevation_rad.resize(6);
  model.azimuth_offset_rad.resize(6);
  model.columns = 24;
  tests::DriverQuirks quirks;
  quirks.missing = 0.1;
  RecordedCloud cloud = tests::RoomCloud(model, quirks, seed);
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.time_s.push_back(0.1f * static_cast<float>(i % 24) / 24.0f);
    cloud.kind.push_back(cloud.p_lidar[i].allFinite() ? core::ReturnKind::kHit : core::ReturnKind::kVoid);
  }
  return cloud;
}

std::string BigEndianPly() {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 20\nproperty float x\nproperty float y\n"
      "property float z\nproperty list uchar short tags\nend_header\n";
  for (int i = 0; i < 20; ++i)
    bytes += std::string("\x3f\x80\x00\x00\x40\x00\x00\x00\x3f\x80\x00\x00\x01\x00\x07", 15);
  return bytes;
}

std::string BinaryGraph() {
  std::string bytes;
  const auto put_vector = [&](std::initializer_list<double> values) {
    Put(&bytes, static_cast<int32_t>(values.size()));
    for (const double v : values) Put(&bytes, v);
  };
  Put(&bytes, uint32_t{2});
  for (uint32_t node = 0; node < 2; ++node) {
    Put(&bytes, 5 + node);
    for (uint32_t i = 0; i < 5 + node; ++i) put_vector({1.0 + i, 2.0, 0.5});
    put_vector({0.5 * node, 0.0, 1.0});
    put_vector({1.0, 0.0, 0.0, 0.0});
    Put(&bytes, node);
  }
  Put(&bytes, uint32_t{1});
  Put(&bytes, uint32_t{0});
  Put(&bytes, uint32_t{1});
  put_vector({0.5, 0.0, 0.0});
  put_vector({1.0, 0.0, 0.0, 0.0});
  Put(&bytes, 1.0);
  return bytes;
}

void ReadGraph(std::string_view bytes, const fs::path& file) {
  const auto index = mapping::IndexScanGraph(bytes, file.string());
  for (size_t i = 0; i < index.nodes.size(); ++i) mapping::ReadScanOfGraph(bytes, index, i, file.string());
}

void ReadLog(const std::string& scans, const std::string& lidar) {
  mapping::RecordedLogOptions options;
  options.scans = scans;
  options.lidar = lidar;
  const mapping::RecordedLog log(options);
  for (size_t i = 0; i < log.size(); ++i) log.Read(i);
}

/// Two clouds and, on topics of their own, the poses of each kind.
std::string SmallBag() {
  using tests::BagHeaderBytes, tests::PoseBytes, tests::Raw, tests::Sized;
  tests::BagWriter bag;
  const std::string covariance(36 * 8, '\0');
  for (uint32_t s = 1; s < 3; ++s) {
    const std::string header = BagHeaderBytes(s, "map"), pose = PoseBytes(0.5 * s);
    bag.Add("/p", "sensor_msgs/PointCloud2", s, tests::CloudMessage(s, 2, 2, std::vector<float>(12, 2.5f)));
    bag.Add("/odom", "nav_msgs/Odometry", s, header + Sized("base") + pose + covariance + covariance);
    bag.Add("/path", "nav_msgs/Path", s, header + Raw(uint32_t{1}) + header + pose);
    bag.Add("/tf", "tf2_msgs/TFMessage", s, Raw(uint32_t{1}) + header + Sized("base") + pose);
    bag.Add("/tf_static", "tf2_msgs/TFMessage", s,
            Raw(uint32_t{1}) + BagHeaderBytes(s, "base") + Sized("lidar") + pose);
  }
  return bag.Bytes();
}

void ReadBag(const fs::path& file) {
  for (const char* topic : {"/odom", "/path", "/tf"}) {
    mapping::RecordedLogOptions options;
    options.scans = file.string();
    options.poses = file.string() + ":" + topic;
    const mapping::RecordedLog log(options);
    for (size_t i = 0; i < log.size(); ++i) log.Read(i);
  }
}

std::string BagOfRos(const std::string& name) {
  return core::ReadFile(core::InstalledFile("tests/data/ros_bags/" + name + ".bag"));
}

void ReadBagOfRos(const fs::path& file) {
  for (const char* topic : {"/points", "/dense"}) ReadLog(file.string() + ":" + topic, "none");
}

/// A data set folder about a file that is damaged: poses.tum, trajectory.tum or dataset.yaml.
void ReadDataset(const fs::path& file) {
  const fs::path folder = file.parent_path() / "dataset";
  fs::remove_all(folder);
  const std::string scan = CloudToPcd(SmallCloud(3), CloudEncoding::kBinary);
  fs::create_directories(folder / "scans");
  for (const char* name : {"100.1.pcd", "100.2.pcd"})
    std::ofstream(folder / "scans" / name, std::ios::binary) << scan;
  std::ofstream(folder / "poses.tum") << "100.1 0 0 0 0 0 0 1\n100.2 0 0 0 0 0 0 1\n";
  std::error_code error;
  fs::copy_file(file, folder / file.filename(), fs::copy_options::overwrite_existing, error);
  ReadLog(folder.string(), "auto");
}

}  // namespace

std::vector<FuzzedReader> LogReaders() {
  const RecordedCloud a = SmallCloud(1), b = SmallCloud(2);
  std::vector<std::string> pcd, ply;
  for (const auto encoding :
       {CloudEncoding::kAscii, CloudEncoding::kBinary, CloudEncoding::kBinaryCompressed}) {
    for (const RecordedCloud* cloud : {&a, &b}) {
      pcd.push_back(CloudToPcd(*cloud, encoding));
      ply.push_back(CloudToPly(*cloud, encoding));
    }
  }
  ply.push_back(BigEndianPly());
  std::string bin;
  for (const core::Vec3f& p : a.p_lidar) {
    for (int k = 0; k < 4; ++k) Put(&bin, k < 3 && p.allFinite() ? p[k] : 0.0f);
  }
  const std::string tum =
      "# t x y z q\n100.1 1 2 3 0 0 0.6 0.8\n100.2 1.5 2 3 0 0 0.6 0.8\n100.3 2 2 3 0 0 0 1\n";
  const std::string kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 2 0 0 1 3\n",
                    matrix = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string calib = "P0: 7 0 6 0 0 7 1 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 -0.3\n";
  const std::string ouster =
      R"({"beam_intrinsics": {"beam_altitude_angles": [10, 0.5, -10], "beam_azimuth_angles": [3, 1, -1]}})";
  return {{"scan.pcd", pcd, [](auto bytes, auto& file) { mapping::ParsePcd(bytes, file.string()); }},
          {"cloud.ply", ply, [](auto bytes, auto& file) { mapping::ParsePlyCloud(bytes, file.string()); }},
          {"000000.bin", {bin}, [](auto bytes, auto& file) { mapping::ParseKittiBin(bytes, file.string()); }},
          {"scans.graph",
           {BinaryGraph(), "NODE 1 2 3 0 0 1\n1 2 3\n4 5 6\nNODE 0 0 0 0 0 0\n1 1 1\n"},
           ReadGraph},
          {"poses.txt",
           {tum, kitti, matrix},
           [](auto bytes, auto& file) { mapping::ParsePoses(bytes, file.string()); }},
          {"calib.txt",
           {calib, kitti.substr(0, kitti.find('\n')), matrix, "1 2 3 0 0 0 1\n"},
           [](auto bytes, auto& file) { mapping::ParseCalibration(bytes, file.string()); }},
          {"ouster.json",
           {ouster},
           [](auto bytes, auto& file) { mapping::ParseOusterMetadata(bytes, file.string()); }},
          {"log_scan.pcd", pcd, [](auto, auto& file) { ReadLog(file.string(), "auto"); }, true},
          {"log.graph", {BinaryGraph()}, [](auto, auto& file) { ReadLog(file.string(), "auto"); }, true},
          {"small.bag", {SmallBag()}, [](auto, auto& file) { ReadBag(file); }, true},
          {"ros.bag",
           {BagOfRos("none"), BagOfRos("bz2"), BagOfRos("lz4")},
           [](auto, auto& file) { ReadBagOfRos(file); },
           true},
          {"trajectory.tum", {tum}, [](auto, auto& file) { ReadDataset(file); }, true},
          {"dataset.yaml",
           {"scene: campus\nlidar: estimate\nmin_range_m: 0.5\nmax_range_m: 90\nrows: 6\n"},
           [](auto, auto& file) { ReadDataset(file); },
           true}};
}

}  // namespace atlas::fuzz
