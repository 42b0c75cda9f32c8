#include "mapping/io/recorded_log.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "core/errors.h"
#include "core/yaml_text.h"
#include "mapping/io/bag_source.h"
#include "mapping/io/pose_matching.h"
#include "mapping/io/scan_from_cloud.h"
#include "mapping/io/scan_source.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::InputError;
using core::Pose;

/// Scans that the beams of a log are estimated from, spread over it.
constexpr size_t kScansForBeams = 5;

void FillIfThere(const fs::path& file, std::string* option) {
  std::error_code error;
  if (option->empty() && fs::is_regular_file(file, error)) *option = file.string();
}

/// @throws InputError, its message after `where`, unless `lidar` is a name or file that RecordedLogOptions
/// takes.
void CheckLidar(const std::string& lidar, const std::string& where) {
  std::vector<std::string> names = core::LidarModelNames();
  names.insert(names.end(), {"auto", "estimate", "none", "FILE.json"});
  const bool known = std::find(names.begin(), names.end(), lidar) != names.end();
  if (!known && fs::path(lidar).extension() != ".json")
    throw InputError(where + core::UnknownName("LiDAR model", lidar, names));
}

/// What dataset.yaml tells of the LiDAR, where the options do not.
void ReadDatasetFile(const fs::path& path, RecordedLogOptions* options) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return;
  try {
    const YAML::Node root = core::LoadYaml(path);
    if (!root.IsMap()) throw InputError(fmt::format("{}: not a map of keys", path.string()));
    const auto range = [&](const char* key, double* value) {
      if (*value != 0.0 || !root[key]) return;
      *value = root[key].as<double>();
      if (!(*value >= 0.0 && *value < 1e5))
        throw InputError(fmt::format("{}: {} is {} m (0 to 1e5)", path.string(), key, *value));
    };
    range("min_range_m", &options->min_range_m);
    range("max_range_m", &options->max_range_m);
    if (options->lidar != "auto" || !root["lidar"]) return;
    options->lidar = root["lidar"].as<std::string>();
    CheckLidar(options->lidar, path.string() + ": lidar: ");
  } catch (const YAML::Exception& problem) {
    throw InputError(fmt::format("{}: {}", path.string(), problem.what()));
  }
}

/// A bag that holds one topic of poses needs no --poses.
RecordedLogOptions WithPosesOfBag(RecordedLogOptions options) {
  std::error_code error;
  const std::string file = SplitTopic(options.scans).first;
  if (!options.poses.empty() || !options.trajectory.empty() || !fs::exists(file, error)) return options;
  const std::vector<std::string> topics = PoseTopicsOf(file);
  if (topics.size() > 1) {
    throw InputError(fmt::format("{}: several topics with poses; give --poses {}:{} or {}:{}", file, file,
                                 topics[0], file, topics[1]));
  }
  if (topics.size() == 1) options.poses = file + ":" + topics[0];
  return options;
}

/// A data set folder taken apart into its files.
RecordedLogOptions Resolved(RecordedLogOptions options) {
  const fs::path folder = options.scans;
  std::error_code error;
  if (NamesBag(options.scans)) return options.without_poses ? options : WithPosesOfBag(std::move(options));
  if (!fs::is_directory(folder, error)) return options;
  for (const char* name : {"scans", "velodyne", "velodyne_points/data"}) {
    if (!fs::is_directory(folder / name, error)) continue;
    options.scans = (folder / name).string();
    break;
  }
  if (!options.without_poses) {
    for (const char* poses : {"poses.tum", "poses.txt"}) FillIfThere(folder / poses, &options.poses);
    FillIfThere(folder / "trajectory.tum", &options.trajectory);
    FillIfThere(folder / "calib.txt", &options.calibration);
  }
  ReadDatasetFile(folder / "dataset.yaml", &options);
  return options;
}

RecordedPoses ReadPosesOf(const std::string& path, const std::optional<Calibration>& calibration,
                          const std::string& lidar_frame) {
  if (!NamesBag(path)) {
    RecordedPoses poses = ReadPoses(path);
    if (calibration) Apply(*calibration, &poses);
    return poses;
  }
  const auto [file, topic] = SplitTopic(path);
  RecordedPoses poses = ReadBagPoses(file, topic, calibration ? "" : lidar_frame);
  if (calibration) Apply(*calibration, &poses);
  return poses;
}

/// Of the catalogue, or an Ouster's JSON file. @throws InputError.
core::LidarModel NamedLidar(const std::string& name_or_file) {
  const bool is_file = fs::path(name_or_file).extension() == ".json";
  return is_file ? ReadOusterMetadata(name_or_file) : core::FindLidarModel(name_or_file);
}

}  // namespace

struct RecordedLog::Impl {
  RecordedLogOptions options;
  std::unique_ptr<ScanSource> source;
  PoseMatch match;
  std::optional<RecordedPoses> trajectory;
  std::optional<BeamFit> beams;
  std::string beams_text;
  bool transposed = false;

  void MeetPoses();
  void FindBeams();
  std::vector<RecordedCloud> CloudsForBeams(bool transpose) const;
  BeamFit Fit(const std::vector<RecordedCloud>& clouds) const;
  void EstimateOrGiveUp();
  ScanRules Rules() const;
  core::PoseTrajectory PosesDuring(const core::LidarScan& scan, const MatchedScan& matched) const;
};

void RecordedLog::Impl::MeetPoses() {
  if (options.without_poses) {
    match = NoPoses(*source);
    return;
  }
  std::optional<Calibration> calibration;
  if (!options.calibration.empty()) calibration = ReadCalibration(options.calibration);
  if (!options.trajectory.empty()) {
    trajectory = ReadPosesOf(options.trajectory, calibration, source->frame());
    if (!trajectory->timed())
      throw InputError(fmt::format("{}: a trajectory needs times (TUM)", options.trajectory));
  }
  if (!options.poses.empty()) {
    match = MatchPoses(*source, ReadPosesOf(options.poses, calibration, source->frame()), options.poses,
                       options.max_dt_s);
  } else if (trajectory) {
    match = MatchPoses(*source, *trajectory, options.trajectory, options.max_dt_s);
  } else {
    match = OwnPoses(*source);
  }
}

std::vector<RecordedCloud> RecordedLog::Impl::CloudsForBeams(bool transpose) const {
  std::vector<RecordedCloud> clouds;
  const size_t scans = match.scans.size(), samples = std::min(kScansForBeams, scans);
  for (size_t k = 0; k < samples; ++k) {
    clouds.push_back(
        source->Read(match.scans[k * (scans - 1) / std::max<size_t>(samples - 1, 1)].source_index));
    if (transpose) clouds.back() = Transposed(clouds.back());
  }
  return clouds;
}

BeamFit RecordedLog::Impl::Fit(const std::vector<RecordedCloud>& clouds) const {
  if (options.lidar == "auto" || options.lidar == "estimate")
    return EstimateBeams(clouds, source->description());
  return FitBeams(NamedLidar(options.lidar), clouds, source->description());
}

void RecordedLog::Impl::EstimateOrGiveUp() {
  const std::vector<RecordedCloud> clouds = CloudsForBeams(false);
  try {
    beams = Fit(clouds);
    return;
  } catch (const InputError& reason) {
    beams_text = reason.what();
  }
  try {
    beams = Fit(CloudsForBeams(true));
    transposed = true;
  } catch (const InputError&) {
    if (options.lidar != "auto") throw InputError(beams_text);
  }
}

void RecordedLog::Impl::FindBeams() {
  if (options.lidar == "none") return;
  const RecordedCloud first = source->Read(match.scans.front().source_index);
  if (!first.organised) {
    if (options.lidar == "estimate")
      throw InputError(fmt::format("{}: not organised: beams cannot be estimated", source->description()));
    if (options.lidar == "auto") return;
    NamedLidar(options.lidar);  // bad where it does not matter is bad, too
    beams_text = fmt::format("clouds are not organised: beams of {} are not used", options.lidar);
    return;
  }
  EstimateOrGiveUp();
  if (!beams) return;
  if (options.min_range_m == 0.0) options.min_range_m = beams->model.min_range_m;
  if (options.max_range_m == 0.0) options.max_range_m = beams->model.max_range_m;
}

ScanRules RecordedLog::Impl::Rules() const {
  return {options.no_return, options.min_range_m, options.max_range_m};
}

core::PoseTrajectory RecordedLog::Impl::PosesDuring(const core::LidarScan& scan,
                                                    const MatchedScan& matched) const {
  core::PoseTrajectory poses;
  const auto [first, last] = std::minmax_element(scan.time_s.begin(), scan.time_s.end());
  const bool timed = first != scan.time_s.end() && *last > *first;
  const auto at_stamp =
      trajectory && timed ? PoseNear(*trajectory, scan.stamp_s, options.max_dt_s) : std::nullopt;
  if (!at_stamp) {
    poses.Add(scan.stamp_s, matched.T_map_lidar);
    return poses;
  }
  // Only motion is taken from the trajectory, so that it may drift away from the poses.
  const Pose T_map_trajectory = matched.T_map_lidar * at_stamp->inverse();
  const double begin = scan.stamp_s + static_cast<double>(*first),
               end = scan.stamp_s + static_cast<double>(*last);
  const auto& times = trajectory->time_s;
  size_t i = static_cast<size_t>(std::upper_bound(times.begin(), times.end(), begin) - times.begin());
  for (i = i > 0 ? i - 1 : 0; i < times.size(); ++i) {
    poses.Add(times[i], T_map_trajectory * trajectory->T_map_lidar[i]);
    if (times[i] >= end) break;
  }
  return poses;
}

RecordedLog::RecordedLog(const RecordedLogOptions& options) : impl_(std::make_unique<Impl>()) {
  CheckLidar(options.lidar, "");
  impl_->options = Resolved(options);
  impl_->source = OpenScans(impl_->options.scans);
  impl_->MeetPoses();
  impl_->FindBeams();
}

RecordedLog::~RecordedLog() = default;
RecordedLog::RecordedLog(RecordedLog&&) noexcept = default;
RecordedLog& RecordedLog::operator=(RecordedLog&&) noexcept = default;

size_t RecordedLog::size() const {
  return impl_->match.scans.size();
}

size_t RecordedLog::scans_without_pose() const {
  return impl_->source->entries().size() - size();
}

std::string RecordedLog::name(size_t index) const {
  return impl_->source->entries()[impl_->match.scans.at(index).source_index].name;
}

double RecordedLog::stamp_s(size_t index) const {
  return impl_->match.scans.at(index).stamp_s;
}

const Pose& RecordedLog::T_map_lidar(size_t index) const {
  return impl_->match.scans.at(index).T_map_lidar;
}

core::SpinEvent RecordedLog::Read(size_t index) const {
  const MatchedScan& matched = impl_->match.scans.at(index);
  RecordedCloud cloud = impl_->source->Read(matched.source_index);
  const core::LidarModel* model = impl_->beams ? &impl_->beams->model : nullptr;
  if (model != nullptr) {
    if (impl_->transposed) cloud = Transposed(cloud);
    if (!cloud.organised || cloud.rows != model->rows() || cloud.columns != model->columns) {
      throw InputError(fmt::format("{}: {} x {} points, {} x {} in the first scan", name(index), cloud.rows,
                                   cloud.columns, model->rows(), model->columns));
    }
  }
  core::SpinEvent event;
  event.scan = ScanFromCloud(cloud, model, impl_->Rules());
  constexpr double kSameClock_s = 1.0;
  event.scan.stamp_s = cloud.stamp_s && std::abs(*cloud.stamp_s - matched.stamp_s) < kSameClock_s
                           ? *cloud.stamp_s
                           : matched.stamp_s;
  event.T_odom_lidar = impl_->PosesDuring(event.scan, matched);
  return event;
}

const std::optional<BeamFit>& RecordedLog::beams() const {
  return impl_->beams;
}

std::string RecordedLog::Describe() const {
  std::string text = fmt::format("{} scans of {}", size(), impl_->options.scans);
  if (const auto& fit = impl_->beams) {
    text +=
        fmt::format(", organised {} x {} (beams {}, residuals {:.3f} and {:.3f} deg{})", fit->model.rows(),
                    fit->model.columns, fit->model.name, core::Degrees(fit->elevation_residual_rad),
                    core::Degrees(fit->azimuth_residual_rad), impl_->transposed ? ", rows for columns" : "");
  } else {
    text += ", unorganised";
    if (!impl_->beams_text.empty()) text += fmt::format(" ({})", impl_->beams_text);
  }
  text += fmt::format("; poses by {}", impl_->match.origin);
  if (impl_->trajectory) text += ", motion within scans by " + impl_->options.trajectory;
  if (scans_without_pose() > 0)
    text += fmt::format("; {} scans without a pose left out", scans_without_pose());
  return text;
}

}  // namespace atlas::mapping
