#include "experiments/record/dataset_writer.h"

#include <fmt/format.h>

#include "core/errors.h"
#include "core/files.h"
#include "core/named_files.h"
#include "mapping/io/cloud_writer.h"
#include "mapping/io/recorded_poses.h"
#include "scenes/catalog.h"
#include "scenes/scene_files.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRouteFile = "route.yaml";  ///< the copy that a data set keeps

void RefuseToMix(const fs::path& folder) {
  std::error_code error;
  const fs::path scans = folder / "scans";
  if (fs::exists(scans, error) && !fs::is_empty(scans, error)) {
    throw core::InputError(
        fmt::format("record: --out {}: holds scans already; name another folder", folder.string()));
  }
}

std::string Describe(const DatasetRecorder& recorder, const std::string& scene, const DatasetCounts& counts,
                     double truth_spacing_m, bool complete) {
  const RecordOptions& options = recorder.options();
  const core::LidarModel& lidar = recorder.lidar();
  const auto& stamps = recorder.stamps_s();
  std::string text =
      "# Recorded by atlas record: a LiDAR carried along a route through a static scene, no physics.\n";
  const auto line = [&text](const std::string& key, const std::string& value) {
    text += key + ": " + value + "\n";
  };
  line("scene", scene);
  line("route", kRouteFile);
  line("lidar", lidar.name);
  line("rows", std::to_string(lidar.rows()));
  line("columns", std::to_string(lidar.columns));
  line("spin_rate_hz", fmt::format("{:g}", lidar.spin_rate_hz));
  line("min_range_m", fmt::format("{:g}", lidar.min_range_m));
  line("max_range_m", fmt::format("{:g}", lidar.max_range_m));
  line("noise", options.noise ? "true" : "false");
  line("range_sigma_m", fmt::format("{:g}", lidar.range_sigma_m));
  line("dropout_probability", fmt::format("{:g}", lidar.dropout_probability));
  line("seed", std::to_string(options.seed));
  line("speed_m_s", fmt::format("{:g}", options.speed_m_s.value_or(recorder.route().speed_m_s)));
  line("length_m", fmt::format("{:.2f}", recorder.length_m()));
  line("duration_s", fmt::format("{:.3f}", recorder.trajectory().poses().back().time_s));
  if (stamps.size() > 1) line("scan_rate_hz", fmt::format("{:.6g}", 1.0 / (stamps[1] - stamps[0])));
  line("scans", std::to_string(counts.scans));
  line("hits", std::to_string(counts.hits));
  line("voids", std::to_string(counts.voids));
  line("dropouts", std::to_string(counts.dropouts));
  line("frame", "map (z up); poses are T_map_lidar, exact");
  if (counts.truth_points > 0) {
    line("truth_points", std::to_string(counts.truth_points));
    line("truth_spacing_m", fmt::format("{:g}", truth_spacing_m));
  }
  line("complete", complete ? "true" : "false");
  return text;
}

void Count(const core::LidarScan& scan, DatasetCounts* counts) {
  ++counts->scans;
  for (const core::ReturnKind kind : scan.kind) {
    if (kind == core::ReturnKind::kHit) ++counts->hits;
    if (kind == core::ReturnKind::kVoid) ++counts->voids;
    if (kind == core::ReturnKind::kDropout) ++counts->dropouts;
  }
}

}  // namespace

size_t WriteTruth(const DatasetRecorder& recorder, const fs::path& path, double spacing_m) {
  const scenes::GroundTruth truth = scenes::SampleGroundTruth(recorder.scene(), spacing_m);
  const std::vector<uint8_t> seen = recorder.SeenPoints(truth.points, truth.normals);
  std::string body;
  size_t kept = 0;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    if (seen[i] == 0) continue;
    body.append(reinterpret_cast<const char*>(truth.points[i].data()), 12);
    body.append(reinterpret_cast<const char*>(truth.normals[i].data()), 12);
    ++kept;
  }
  std::string file = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", kept);
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) file += fmt::format("property float {}\n", name);
  file += "end_header\n" + body;
  core::WriteFileAtomically(path, file);
  return kept;
}

DatasetCounts WriteDataset(DatasetRecorder* recorder, const fs::path& folder, double truth_spacing_m,
                           const std::function<bool(size_t, size_t)>& progress) {
  for (const fs::path& used : {folder, folder / "scans"}) core::RemoveStaleTemporaries(used);
  RefuseToMix(folder);
  const std::string scene = scenes::KeepScene(recorder->options().scene, folder);
  core::CopyFile(recorder->route().file, folder / kRouteFile);
  mapping::WriteTum(folder / "trajectory.tum", recorder->trajectory().poses());
  DatasetCounts counts;
  std::vector<core::StampedPose> poses;
  core::SpinEvent spin;
  bool go_on = true;
  while (go_on && recorder->Next(&spin)) {
    mapping::WriteScan(folder, spin.scan);
    poses.push_back({spin.scan.stamp_s, spin.T_odom_lidar.At(spin.scan.stamp_s)});
    Count(spin.scan, &counts);
    go_on = progress(counts.scans, recorder->stamps_s().size());
  }
  counts.interrupted = counts.scans < recorder->stamps_s().size();
  mapping::WriteTum(folder / "poses.tum", poses);
  if (truth_spacing_m > 0.0 && !counts.interrupted) {
    // Complete only with its truth, which takes a while.
    core::WriteFileAtomically(folder / "dataset.yaml",
                              Describe(*recorder, scene, counts, truth_spacing_m, false));
    counts.truth_points = WriteTruth(*recorder, folder / "truth.ply", truth_spacing_m);
  }
  core::WriteFileAtomically(folder / "dataset.yaml",
                            Describe(*recorder, scene, counts, truth_spacing_m, !counts.interrupted));
  return counts;
}

}  // namespace atlas::experiments
