#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "core/stopwatch.h"
#include "experiments/cli/interrupt.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "experiments/mapping_tools/offline_slam.h"
#include "experiments/report/text_table.h"
#include "experiments/results/run_folder.h"
#include "mapping/atlas/saved_atlas.h"
#include "mapping/atlas/saved_slam.h"
#include "mapping/io/recorded_poses.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

OfflineSlamParams SlamParamsOf(const SlamArguments& arguments) {
  OfflineSlamParams params;
  params.mapper.resolution_m = arguments.resolution_m.value_or(
      arguments.earlier.empty() ? 0.1 : mapping::ResolutionOfAtlas(arguments.earlier));
  params.mapper.integrator = mapping::IntegratorParams{};
  params.mapper.integrator.max_range_m = arguments.max_range_m;
  params.mapper.integrator.threads = arguments.threads;
  params.lidar_odometry.threads = arguments.threads;
  core::ParamSource source;
  for (const std::string& assignment : arguments.assignments) source.MergeAssignment(assignment);
  source.Load(&params);
  if (params.mapper.name != "atlas")
    throw core::InputError(
        fmt::format("mapper.name: {}: atlas slam builds an atlas (atlas)", params.mapper.name));
  return params;
}

/// The user's own odometry, carried over to the LiDAR.
std::optional<mapping::RecordedPoses> OdometryOf(const SlamArguments& arguments) {
  if (arguments.odometry.empty()) return std::nullopt;
  mapping::RecordedPoses poses = mapping::ReadPoses(arguments.odometry);
  if (!poses.timed())
    throw core::InputError(fmt::format("{}: odometry needs times (TUM)", arguments.odometry.string()));
  if (!arguments.log.calibration.empty())
    mapping::Apply(mapping::ReadCalibration(arguments.log.calibration), &poses);
  return poses;
}

std::string MissesScan(const SlamArguments& arguments, double time_s, const std::string& name) {
  return fmt::format("{}: no pose within {} s of {:.3f} s, in scan {}", arguments.odometry.string(),
                     arguments.log.max_dt_s, time_s, name);
}

/// @throws InputError where odometry does not reach the scan's ends within max_dt_s.
core::PoseTrajectory During(const mapping::RecordedPoses& odometry, const core::LidarScan& scan,
                            const SlamArguments& arguments, const std::string& name) {
  const auto [first, last] = std::minmax_element(scan.time_s.begin(), scan.time_s.end());
  const bool empty = first == scan.time_s.end();
  const double begin_s = scan.stamp_s + (empty ? 0.0 : static_cast<double>(*first));
  const double end_s = scan.stamp_s + (empty ? 0.0 : static_cast<double>(*last));
  core::PoseTrajectory poses;
  const auto add = [&](double time_s) {
    const auto pose = mapping::PoseNear(odometry, time_s, arguments.log.max_dt_s);
    if (!pose) throw core::InputError(MissesScan(arguments, time_s, name));
    poses.Add(time_s, *pose);
  };
  add(begin_s);
  const auto& times = odometry.time_s;
  for (auto i = std::upper_bound(times.begin(), times.end(), begin_s); i != times.end() && *i < end_s; ++i)
    poses.Add(*i, odometry.T_map_lidar[static_cast<size_t>(i - times.begin())]);
  if (end_s > begin_s) add(end_s);
  return poses;
}

struct SlamOutcome {
  size_t scans = 0;
  bool interrupted = false;
  double wall_s = 0.0;
  std::exception_ptr broken;  ///< what ended the log before its time
};

void Follow(const SlamArguments& arguments, const mapping::RecordedLog& log,
            const std::optional<mapping::RecordedPoses>& odometry, OfflineSlam* slam, SlamOutcome* outcome) {
  const size_t count = arguments.limit > 0 ? std::min(arguments.limit, log.size()) : log.size();
  const core::Stopwatch wall;
  ProgressBar bar("slam", count);
  try {
    double before_s = -1e300;
    for (size_t i = 0; i < count && !(outcome->interrupted = Interrupted()); ++i) {
      bar.Show(i, fmt::format("{:.0f} m, {}{} loops, {:.0f} MB", slam->way_m(),
                              slam->located() ? "" : "not recognised yet, ", slam->loops(),
                              static_cast<double>(slam->map().Bytes()) / 1e6));
      core::SpinEvent spin = log.Read(i);
      if (spin.scan.stamp_s <= before_s)
        throw core::InputError(fmt::format("{}: scan {} ({:.6f} s) is not after the one before it",
                                           arguments.log.scans, log.name(i), spin.scan.stamp_s));
      before_s = spin.scan.stamp_s;
      std::optional<core::PoseTrajectory> prior;
      if (odometry) prior = During(*odometry, spin.scan, arguments, log.name(i));
      slam->Add(std::move(spin.scan), prior);
      ++outcome->scans;
    }
  } catch (const std::exception&) {
    if (outcome->scans < 2) throw;
    outcome->broken = std::current_exception();
  }
  slam->Settle();
  outcome->wall_s = wall.seconds();
  bar.Finish(fmt::format("{} scans{}", outcome->scans, outcome->interrupted ? ", interrupted" : ""));
}

/// "time" and the upper triangle, row by row.
std::string CovarianceRows(const std::vector<SlamPose>& trajectory) {
  std::string text =
      "# time, then the upper triangle of the covariance of xi in T Exp(xi) row by row: "
      "x y z (m) and rotation (rad) in the LiDAR's frame; the first scan is held\n";
  for (const SlamPose& pose : trajectory) {
    if (!pose.covariance) continue;
    text += fmt::format("{:.9f}", pose.time_s);
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column)
        text += fmt::format(" {:.6e}", (*pose.covariance)(row, column));
    }
    text += "\n";
  }
  return text;
}

void WriteSlam(const SlamArguments& arguments, const OfflineSlam& slam, const fs::path& folder) {
  ProgressBar bar("write", 4);
  const std::vector<SlamPose> trajectory = slam.Trajectory();
  std::vector<core::StampedPose> poses;
  for (const SlamPose& pose : trajectory) poses.push_back({pose.time_s, pose.T_map_lidar});
  bar.Show(0, "trajectory");
  mapping::WriteTum(folder / "trajectory.txt", poses);
  core::WriteFileAtomically(folder / "trajectory_covariance.txt", CovarianceRows(trajectory));
  bar.Show(1, "graph");
  mapping::WriteG2o(folder / "graph.g2o", slam.Graph());
  bar.Show(2, "mesh");
  core::WritePly(folder / "mesh.ply", slam.Mesh(arguments.threads));
  bar.Show(3, "atlas");
  slam.Save(folder);
  bar.Finish(folder.string());
}

double Share(size_t part, size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
}

TextTable OutcomeRows(const OfflineSlam& slam, const SlamOutcome& outcome) {
  const mapping::OdometryHealth& health = slam.health();
  TextTable table;
  table.heading = {"SLAM", ""};
  table.left = {true, false};
  const auto row = [&](const std::string& name, std::string value) {
    table.rows.push_back({name, std::move(value)});
  };
  row("scans", fmt::format("{}", outcome.scans));
  row("way, m", fmt::format("{:.1f}", slam.way_m()));
  row("keyframes", fmt::format("{}", slam.keyframes()));
  row("loops", fmt::format("{}", slam.loops()));
  row("submaps", fmt::format("{}", slam.map().SubmapCount()));
  row("scans lost, %", fmt::format("{:.2f}", 100.0 * Share(health.lost, health.revolutions)));
  row("scans degenerate, %", fmt::format("{:.2f}", 100.0 * Share(health.degenerate, health.revolutions)));
  row("ms a scan", fmt::format("{:.1f}", 1e3 * outcome.wall_s / static_cast<double>(outcome.scans)));
  row("map in memory, MB", fmt::format("{:.1f}", static_cast<double>(slam.map().Bytes()) / 1e6));
  return table;
}

void WriteSlamSummary(const fs::path& folder, const mapping::RecordedLog& log, const OfflineSlam& slam,
                      const SlamOutcome& outcome) {
  const mapping::OdometryHealth& health = slam.health();
  const nlohmann::ordered_json json = {{"status", outcome.broken        ? "failed"
                                                  : outcome.interrupted ? "interrupted"
                                                                        : "completed"},
                                       {"log", log.Describe()},
                                       {"scans", outcome.scans},
                                       {"way_m", slam.way_m()},
                                       {"keyframes", slam.keyframes()},
                                       {"loops", slam.loops()},
                                       {"submaps", slam.map().SubmapCount()},
                                       {"scans_lost", health.lost},
                                       {"scans_degenerate", health.degenerate},
                                       {"wall_s", outcome.wall_s},
                                       {"map_bytes", slam.map().Bytes()}};
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  core::WriteFileAtomically(folder / "summary.json", json.dump(2, ' ', false, kReplace) + "\n");
}

/// The atlas itself, or the one in what `atlas slam` and `atlas run` write.
fs::path AtlasIn(const fs::path& folder) {
  for (const fs::path& atlas : {folder, folder / "atlas"}) {
    if (!mapping::IsAtlasFolder(atlas)) continue;
    std::error_code error;
    if (fs::exists(mapping::SlamFolderOf(atlas), error)) return atlas;
    throw core::InputError(fmt::format(
        "{}: no folder slam: only an atlas whose keyframes slam placed can be gone on with", atlas.string()));
  }
  throw core::InputError(fmt::format("{}: no saved atlas there", folder.string()));
}

fs::path SlamFolder(const SlamArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const fs::path path = fs::path(arguments.log.scans).lexically_normal();
  const fs::path name = path.has_filename() ? path.stem() : path.parent_path().filename();
  return fs::path("runs") / "slam" / (name.empty() || name == "." || name == ".." ? fs::path("log") : name);
}

}  // namespace

int SlamCommand(const SlamArguments& given) {
  EndAtOnceOnSignal();
  SlamArguments arguments = given;
  if (!arguments.earlier.empty()) arguments.earlier = AtlasIn(arguments.earlier);
  const OfflineSlamParams params = SlamParamsOf(arguments);
  mapping::RecordedLogOptions options = arguments.log;
  options.no_return = arguments.no_return == "void" ? core::ReturnKind::kVoid : core::ReturnKind::kDropout;
  options.without_poses = true;
  const fs::path folder = SlamFolder(arguments);
  if (HoldsRun(folder)) {
    throw core::InputError(folder.string() +
                           ": holds a run, whose map this would overwrite (choose another --out)");
  }
  const std::optional<mapping::RecordedPoses> odometry = OdometryOf(arguments);
  const mapping::RecordedLog log(options);
  if (log.size() < 2)
    throw core::InputError(options.scans + ": one scan tells no way (two or more; atlas map maps one)");
  if (odometry && !mapping::PoseNear(*odometry, log.stamp_s(0), options.max_dt_s))
    throw core::InputError(MissesScan(arguments, log.stamp_s(0), log.name(0)));
  core::RemoveStaleTemporaries(folder);
  core::AtomicFile(folder / "trajectory.txt");  // a folder that cannot be written is found before the work
  std::optional<core::LidarModel> lidar;
  if (log.beams()) lidar = log.beams()->model;
  OfflineSlam slam(params, lidar, arguments.earlier);
  std::cout << core::Printable(log.Describe()) << std::endl;
  StopInOrderOnSignal();
  SlamOutcome outcome;
  Follow(arguments, log, odometry, &slam, &outcome);
  WriteSlam(arguments, slam, folder);
  WriteSlamSummary(folder, log, slam, outcome);
  std::cout << ToTerminal(OutcomeRows(slam, outcome));
  constexpr double kManyLost = 0.1;
  if (Share(slam.health().lost, outcome.scans) > kManyLost)
    std::cout << "the way was lost again and again: what came after the first loss is not to be trusted\n";
  std::cout << fmt::format(
      "{}: trajectory.txt trajectory_covariance.txt graph.g2o mesh.ply atlas/ summary.json\n",
      folder.string());
  if (outcome.broken) std::rethrow_exception(outcome.broken);
  return outcome.interrupted ? 130 : 0;
}

}  // namespace atlas::experiments
