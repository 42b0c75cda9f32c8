// `atlas map`, `mesh`, `eval` and `export` as a user meets them.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/files.h"
#include "core/mesh.h"
#include "mapping/io/cloud_writer.h"
#include "tests/support/command_line.h"
#include "tests/support/recorded_scans.h"
#include "tests/support/shared_data.h"

namespace {

namespace fs = std::filesystem;
using atlas::core::Vec3;
using atlas::core::Vec3f;
using atlas::tests::Outcome;

class MapCommand : public atlas::tests::CommandLine {
 protected:
  /// Scans of an empty room of 12 x 8 x 5 m by an OS0-64 at three places, and their poses.
  void WriteRoomLog() {
    const atlas::core::LidarModel lidar = atlas::core::FindLidarModel("os0_64");
    std::string poses;
    for (int i = 0; i < 3; ++i) {
      const Vec3 p(1.5 * i - 1.5, 0.5 * i, 0.1 * i);
      const auto cloud = atlas::tests::RoomCloud(lidar, {}, static_cast<uint64_t>(i), p);
      atlas::core::WriteFileAtomically(
          dir_ / "log" / "scans" / ("10" + std::to_string(i) + ".000.pcd"),
          atlas::mapping::CloudToPcd(cloud, atlas::mapping::CloudEncoding::kBinaryCompressed));
      poses += "10" + std::to_string(i) + ".0 " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
               std::to_string(p.z()) + " 0 0 0 1\n";
    }
    Write("log/poses.tum", poses);
  }
  /// The room's walls, floor and ceiling where every scan saw them, a point every 4 cm.
  void WriteRoomTruth() {
    atlas::core::PointCloud truth;
    const auto add = [&](const Vec3& p) { truth.points.push_back(p.cast<float>()); };
    for (double u = -3.5; u < 3.5; u += 0.04) {
      for (double v = -1.0; v < 1.5; v += 0.04) {
        for (const double side : {-1.0, 1.0}) {
          add({6.0 * side, u, v});
          add({u, 4.0 * side, v});
        }
      }
    }
    atlas::core::WritePly(dir_ / "truth.ply", truth);
  }
  nlohmann::json Json(const std::string& name) {
    return nlohmann::json::parse(atlas::core::ReadFile(dir_ / name));
  }
  void ExpectDone(const std::string& arguments) {
    const Outcome outcome = Atlas(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.text;
  }
};

TEST_F(MapCommand, ARoomIsMappedMeshedScoredAndExported) {
  WriteRoomLog();
  WriteRoomTruth();
  for (const std::string field : {"occupancy", "tsdf"}) {
    SCOPED_TRACE(field);
    ExpectDone("map --scans log --out " + field + " --mesh --field " + field);
    for (const char* file : {"map.atlas", "cloud.ply", "mesh.ply", "summary.json"}) {
      EXPECT_TRUE(fs::exists(dir_ / field / file)) << file;
    }
    const nlohmann::json summary = Json(field + "/summary.json");
    EXPECT_EQ(summary["status"], "completed");
    EXPECT_EQ(summary["scans"], 3);
    EXPECT_EQ(summary["scans_without_pose"], 0);
    EXPECT_EQ(summary["field"], field);
    EXPECT_GT(summary["integration_cpu_ms_mean"], 0.0);
    // What three scans see of the room's 480 m3, between 45 degrees up and down.
    EXPECT_GT(summary["free_m3"], 250.0);
    EXPECT_LT(summary["free_m3"], 485.0);

    // Rows of beams meet the walls up to 15 cm apart: three scans of them close no mesh of occupancy.
    const std::string points = field == "occupancy" ? " --points voxels" : "";
    ExpectDone("eval " + field + "/map.atlas --truth truth.ply --json score.json" + points);
    const nlohmann::json score = Json("score.json");
    EXPECT_GT(score["as_is"]["coverage"][1]["share"], 0.9);
    EXPECT_LT(score["as_is"]["completeness_mean_m"], 0.05);
    EXPECT_LT(score["alignment_m"], 0.02);

    ExpectDone("mesh " + field + "/map.atlas --out again.ply --threads 1");
    EXPECT_EQ(atlas::core::ReadFile(dir_ / "again.ply"), atlas::core::ReadFile(dir_ / field / "mesh.ply"));
    ExpectDone("eval again.ply --truth truth.ply");
    ExpectDone("eval " + field + "/cloud.ply --truth truth.ply --radius 0.1");
    for (const char* file : {"map.bt", "map.ot", "voxels.ply"}) {
      ExpectDone("export " + field + "/map.atlas --out " + file);
      EXPECT_GT(fs::file_size(dir_ / file), 1000u);
    }
  }
}

TEST_F(MapCommand, ThreadsChangeNoByteOfTheMap) {
  WriteRoomLog();
  std::string first;
  for (const std::string threads : {"1", "2", "4"}) {
    ExpectDone("map --scans log --resolution 0.1 --out t" + threads + " --threads " + threads);
    const std::string bytes = atlas::core::ReadFile(dir_ / ("t" + threads) / "map.atlas");
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << threads;
  }
}

TEST_F(MapCommand, ARollingMapKeepsWhatIsNear) {
  WriteRoomLog();
  ExpectDone("map --scans log --resolution 0.05 --out all");
  ExpectDone("map --scans log --resolution 0.05 --out near --local 2");
  EXPECT_LT(Json("near/summary.json")["free_m3"], Json("all/summary.json")["free_m3"]);
}

TEST_F(MapCommand, PosesFarFromTheirOriginAreMappedAboutTheFirst) {
  WriteRoomLog();
  Write(
      "log/poses.tum",
      "100 691000.5 5335000 500 0 0 0 1\n101 691002 5335000.5 500.1 0 0 0 1\n102 691003.5 5335001 500.2 0 0 "
      "0 1\n");
  ExpectDone("map --scans log --resolution 0.1 --out far");
  const nlohmann::json summary = Json("far/summary.json");
  EXPECT_EQ(summary["map_origin_m"][0], 691000.0);
  EXPECT_GT(summary["free_m3"], 250.0);
}

TEST_F(MapCommand, InterruptLeavesAWholeMap) {
  WriteRoomLog();
  constexpr int kScans = 3000;
  std::string poses;
  fs::create_directories(dir_ / "long" / "scans");
  for (int i = 0; i < kScans; ++i) {
    fs::create_symlink(dir_ / "log" / "scans" / "100.000.pcd",
                       dir_ / "long" / "scans" / fmt::format("{}.000.pcd", 1000 + i));
    poses += fmt::format("{} 0 0 0 0 0 0 1\n", 1000 + i);
  }
  Write("long/poses.tum", poses);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (chdir(dir_.c_str()) != 0 || freopen("/dev/null", "w", stderr) == nullptr ||
        freopen("/dev/null", "w", stdout) == nullptr) {
      _exit(9);
    }
    execl(atlas::tests::AtlasBinary().c_str(), "atlas", "map", "--scans", "long", "--out", "out", nullptr);
    _exit(9);
  }
  for (int i = 0; i < 600 && !fs::exists(dir_ / "out"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const nlohmann::json summary = Json("out/summary.json");
  EXPECT_EQ(summary["status"], "interrupted");
  EXPECT_GT(summary["scans"], 0);
  EXPECT_LT(summary["scans"], kScans);
  ExpectDone("mesh out/map.atlas");
}

TEST_F(MapCommand, ABrokenScanKeepsTheMapSoFar) {
  WriteRoomLog();
  const fs::path second = dir_ / "log/scans/101.000.pcd";
  fs::resize_file(second, fs::file_size(second) / 2);
  const Outcome outcome = Atlas("map --scans log --lidar none --resolution 0.1 --out out");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.text.find("101.000.pcd"), std::string::npos) << outcome.text;
  const nlohmann::json summary = Json("out/summary.json");
  EXPECT_EQ(summary["status"], "failed");
  EXPECT_EQ(summary["scans"], 1);
  EXPECT_NE(std::string(summary["error"]).find("101.000.pcd"), std::string::npos);
  ExpectDone("mesh out/map.atlas");
  // Where nothing was mapped there is nothing to keep.
  fs::resize_file(dir_ / "log/scans/100.000.pcd", 200);
  EXPECT_EQ(Atlas("map --scans log --lidar none --out none").exit_code, 2);
  EXPECT_FALSE(fs::exists(dir_ / "none/map.atlas"));
}

TEST_F(MapCommand, AFileThatDoesNotFitCostsNoOther) {
  WriteRoomLog();
  ExpectDone("map --scans log --resolution 0.1 --mesh --out whole");
  const auto size = [&](const std::string& name) { return fs::file_size(dir_ / "whole" / name); };
  ASSERT_GT(size("mesh.ply"), size("map.atlas") + 4096);
  const std::string blocks = std::to_string(size("map.atlas") / 512 + 2);
  const Outcome outcome =
      Atlas("list gains > gains; ulimit -f " + blocks + "; '" + atlas::tests::AtlasBinary().string() +
            "' map --scans log --resolution 0.1 --mesh --out out");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.text.find("cannot write (File too large)"), std::string::npos) << outcome.text;
  EXPECT_EQ(Json("out/summary.json")["status"], "failed");
  EXPECT_EQ(atlas::core::ReadFile(dir_ / "out/map.atlas"), atlas::core::ReadFile(dir_ / "whole/map.atlas"));
  EXPECT_FALSE(fs::exists(dir_ / "out/mesh.ply"));
}

TEST_F(MapCommand, BadInputIsOneLine) {
  WriteRoomLog();
  ExpectDone("map --scans log --resolution 0.2 --out good");
  fs::create_directories(dir_ / "empty");
  Write("other.tum", "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n");
  ExpectRefusal("map", {"--scans"});
  ExpectRefusal("map --scans nowhere", {"nowhere"});
  ExpectRefusal("map --scans empty", {"empty"});
  ExpectRefusal("map --scans log --poses none.tum", {"none.tum", "no such file"});
  ExpectRefusal("map --scans log --poses other.tum", {"pose"});
  ExpectRefusal("map --scans log --resolution 0", {"--resolution", "0"});
  ExpectRefusal("map --scans log --resolution x", {"--resolution", "x"});
  ExpectRefusal("map --scans log --max-range -3", {"--max-range"});
  ExpectRefusal("map --scans log --field foo", {"--field", "occupancy", "tsdf"});
  ExpectRefusal("map --scans log --no-return maybe", {"--no-return", "dropout"});
  ExpectRefusal("map --scans log --lidar vlp61", {"did you mean 'vlp16'"});
  ExpectRefusal("map --scans log --threads 0", {"--threads"});
  ExpectRefusal("map --scans log --set mapper.sigma_min=1", {"did you mean 'mapper.sigma_min_m'"});
  ExpectRefusal("map --scans log --set mapper.resolution_m=99", {"mapper.resolution_m", "99"});
  Write("blocker", "a file where a folder should be");
  ExpectRefusal("map --scans log --out blocker/x", {"blocker"});
  ExpectRefusal("mesh none.atlas", {"none.atlas", "no such file"});
  ExpectRefusal("mesh other.tum", {"other.tum", "not a map file"});
  ExpectRefusal("mesh good/map.atlas --out mesh.obj", {".obj", ".ply"});
  ExpectRefusal("export good/map.atlas --out map.bth", {"did you mean '.bt'"});
  ExpectRefusal("eval good/map.atlas", {"--truth"});
  ExpectRefusal("eval good/map.atlas --truth none.ply", {"none.ply"});
  ExpectRefusal("eval good/map.atlas --truth good/cloud.ply --radius 0", {"--radius"});
  ExpectRefusal("eval other.tum --truth good/cloud.ply", {"other.tum"});
}

TEST_F(MapCommand, DamagedMapsAreOneLine) {
  WriteRoomLog();
  ExpectDone("map --scans log --resolution 0.2 --out good");
  const std::string bytes = atlas::core::ReadFile(dir_ / "good" / "map.atlas");
  std::string flipped = bytes, future = bytes;
  flipped[bytes.size() / 2] ^= 4;
  future[8] = 9;
  Write("flipped.atlas", flipped);
  Write("future.atlas", future);
  Write("short.atlas", bytes.substr(0, bytes.size() / 2));
  ExpectRefusal("mesh flipped.atlas", {"flipped.atlas", "checksum"});
  ExpectRefusal("mesh future.atlas", {"future.atlas", "newer version", "9", "up to 1"});
  ExpectRefusal("eval short.atlas --truth good/cloud.ply", {"short.atlas", "ends early"});
}

/// A scan graph and a pair of clouds with the relation between them; the real ones too, where they are.
TEST_F(MapCommand, GraphsAndPairsMapWithOneCommandEach) {
  const atlas::core::LidarModel lidar = atlas::core::FindLidarModel("os0_64");
  std::string graph;
  for (const int i : {0, 1}) {
    const auto cloud = atlas::tests::RoomCloud(lidar, {}, static_cast<uint64_t>(i), Vec3(i, 0.0, 0.0));
    atlas::core::WriteFileAtomically(
        dir_ / "pair" / (i == 0 ? "target.pcd" : "source.pcd"),
        atlas::mapping::CloudToPcd(cloud, atlas::mapping::CloudEncoding::kBinary));
    graph += "NODE " + std::to_string(i) + " 0 0 0 0 0\n";
    for (size_t k = 0; k < cloud.size(); k += 8) {
      const Vec3f& p = cloud.p_lidar[k];
      if (!p.allFinite()) continue;
      graph += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    }
  }
  Write("pair/T_target_source.txt", "1 0 0 1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  Write("room.graph", graph);
  const auto expect_mapped = [&](const std::string& scans, const std::string& out, int count) {
    ExpectDone("map --scans '" + scans + "' --mesh --out " + out);
    EXPECT_EQ(Json(out + "/summary.json")["scans"], count);
    EXPECT_TRUE(fs::exists(dir_ / out / "mesh.ply"));
  };
  const auto expect_pair = [&](const std::string& scans, const std::string& out) {
    expect_mapped(scans, out, 2);
    ExpectDone("eval " + out + "/cloud.ply --truth '" + scans + "/" +
               (out == "pair_map" ? "target.pcd" : "target.ply") + "' --json score.json");
    EXPECT_GT(Json("score.json")["as_is"]["coverage"][1]["share"], 0.99);
  };
  expect_mapped("room.graph", "graph_map", 2);
  expect_pair("pair", "pair_map");
  if (const auto real = atlas::tests::SharedData("octomap/spherical_scan.graph")) {
    expect_mapped(real->string(), "real_graph_map", 1);
  }
  if (const auto real = atlas::tests::SharedData("scan_pair")) expect_pair(real->string(), "real_pair_map");
}

}  // namespace
