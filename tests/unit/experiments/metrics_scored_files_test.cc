// The files that coverage was counted from, read by other eyes: a reader of this test's own and, where Python
// has numpy, docs/recompute_coverage.py.
#include "experiments/results/scored_files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/files.h"
#include "core/rng.h"
#include "experiments/judge/coverage.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;

/// A plate of 60 x 40 x 2 cm and a sheet beside it, seen from above with noise under a small misalignment.
struct Seen {
  Seen() {
    core::Rng rng(21);
    for (double x = -0.3; x <= 0.3; x += 0.01) {
      for (double y = -0.2; y <= 0.2; y += 0.01) {
        for (const double z : {-0.01, 0.01}) Truth(Vec3(x, y, z), Vec3(0, 0, z > 0 ? 1 : -1), 0);
        Truth(Vec3(x + 1.0, y, 0.0), Vec3(0, 0, -1), 1);
      }
    }
    const core::Pose T_cloud_truth =
        core::MakePose(core::RotationFromYawPitchRoll(0.01, 0.0, 0.005), Vec3(0.01, -0.01, 0.02));
    for (size_t i = 0; i < truth.points.size(); i += 2) {
      const Vec3 q = truth.points[i].cast<double>();
      if (q.z() < 0.0 || q.x() > 1.2) continue;
      const Vec3 p = T_cloud_truth * (q + 0.01 * Vec3(rng.Normal(), rng.Normal(), rng.Normal()));
      const Vec3 sensor = T_cloud_truth * Vec3(rng.Uniform(-1, 1), rng.Uniform(-1, 1), 2.0);
      cloud.Add(p.cast<float>(), sensor.cast<float>());
    }
    for (size_t i = 0; i < truth.points.size(); ++i) attainable.push_back(i % 7 != 0 ? 1 : 0);
  }
  void Truth(const Vec3& p, const Vec3& n, uint8_t two_sided) {
    truth.points.push_back(p.cast<float>());
    truth.normals.push_back(n.cast<float>());
    truth.two_sided.push_back(two_sided);
    truth.part.push_back(0);
  }

  scenes::GroundTruth truth;
  mapping::ReturnCloud cloud;
  std::vector<uint8_t> attainable;
};

class ScoredFiles : public ::testing::Test {
 protected:
  ScoredFiles() : folder_(std::filesystem::temp_directory_path() / "atlas_scored_files") {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    meter_.AddCloud(seen_.cloud);
    WriteScoredTruth(folder_ / "ground_truth.ply", seen_.truth, seen_.attainable);
    WriteScoredCloud(folder_ / "cloud.ply", meter_.kept(), meter_.kept().points.size());
    WriteAlignment(folder_ / "alignment.txt", meter_.T_truth_cloud_counted());
  }
  ~ScoredFiles() override { std::filesystem::remove_all(folder_); }

  double OfAttainable() const { return ShareOf(meter_.covered_outer(), seen_.attainable); }

  Seen seen_;
  CoverageMeter meter_{seen_.truth, {}};
  std::filesystem::path folder_;
};

/// The bytes after the header, cut into records.
std::vector<std::string> Records(const std::filesystem::path& path, size_t record_bytes) {
  const std::string content = core::ReadFile(path);
  const std::string end = "end_header\n";
  size_t at = content.find(end) + end.size();
  std::vector<std::string> records;
  for (; at + record_bytes <= content.size(); at += record_bytes)
    records.push_back(content.substr(at, record_bytes));
  EXPECT_EQ(at, content.size()) << path;
  return records;
}

Vec3 VectorAt(const std::string& record, size_t index) {
  float v[3];
  std::memcpy(v, record.data() + 12 * index, 12);
  return {v[0], v[1], v[2]};
}

TEST_F(ScoredFiles, BruteForceOverThemGivesTheMetersCoverage) {
  core::Pose T = core::Pose::Identity();
  std::istringstream numbers(core::ReadFile(folder_ / "alignment.txt"));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers >> T.matrix()(row, column);
  }
  const auto truth = Records(folder_ / "ground_truth.ply", 26), cloud = Records(folder_ / "cloud.ply", 24);
  ASSERT_EQ(truth.size(), seen_.truth.points.size());
  double covered = 0, outer = 0, attainable = 0, both = 0;
  for (const std::string& point : truth) {
    const Vec3 q = VectorAt(point, 0), n = VectorAt(point, 1);
    bool any = false, front = false;
    for (const std::string& seen : cloud) {
      if ((T * VectorAt(seen, 0) - q).norm() > 0.043) continue;
      any = true;
      front = front || point[25] == 1 || n.dot(T * VectorAt(seen, 1) - q) > 0.0;
    }
    covered += any;
    outer += front;
    attainable += point[24];
    both += front && point[24] == 1;
  }
  const auto count = static_cast<double>(truth.size());
  EXPECT_NEAR(covered / count, meter_.coverage(), 1e-4);
  EXPECT_NEAR(outer / count, meter_.coverage_outer(), 1e-4);
  EXPECT_NEAR(both / attainable, OfAttainable(), 1e-4);
  EXPECT_GT(meter_.coverage(), meter_.coverage_outer() + 0.2);  // the plate's far face
  EXPECT_GT(meter_.coverage_outer(), 0.3);
}

TEST_F(ScoredFiles, ThePythonScriptAgreesAndNoticesADifference) {
  // Debian's own, whatever python3 comes first in the path: its numpy is one of the launcher's packages.
  const std::string python = "/usr/bin/python3";
  ASSERT_EQ(std::system((python + " -c 'import numpy' > /dev/null 2>&1").c_str()), 0)
      << "python3-numpy is not installed";
  const std::string command =
      fmt::format("{} '{}' '{}' > /dev/null", python,
                  core::InstalledFile("docs/recompute_coverage.py").string(), folder_.string());
  core::WriteFileAtomically(folder_ / "config.yaml", "mission:\n  coverage_radius_m: 0.043\n");
  const auto attainable =
      static_cast<double>(std::count(seen_.attainable.begin(), seen_.attainable.end(), uint8_t{1})) /
      static_cast<double>(seen_.attainable.size());
  for (const double error : {0.0, 2e-4}) {
    core::WriteFileAtomically(
        folder_ / "summary.json",
        fmt::format("{{\"coverage\": {:.6f}, \"coverage_outer\": {:.6f}, \"coverage_attainable\": {:.6f}, "
                    "\"coverage_of_attainable\": {:.6f}}}",
                    meter_.coverage(), meter_.coverage_outer() + error, attainable, OfAttainable()));
    EXPECT_EQ(std::system(command.c_str()) == 0, error == 0.0) << command;
  }
}

}  // namespace
}  // namespace atlas::experiments
