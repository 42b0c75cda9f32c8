#include "experiments/bench/odometry_bench.h"

#include <fmt/format.h>

#include "core/files.h"
#include "core/resource_use.h"
#include "core/rng.h"
#include "experiments/record/recorder.h"
#include "experiments/report/text_table.h"
#include "mapping/slam/lidar_odometry.h"

namespace atlas::experiments {
namespace {

using core::Pose;
using core::PoseTrajectory;

constexpr double kRate_hz = 10.0;
constexpr size_t kWindowStride = 5;

double TurnOf(const Pose& T) {
  return Eigen::AngleAxisd(T.linear()).angle();
}

/// What an odometer makes of the true way: noise grows with it as a random walk, biases steadily.
PoseTrajectory BiasedPrior(const PoseTrajectory& truth, core::Rng rng) {
  constexpr double kEvery_m = 2.0, kSigma_m = 0.02, kTooLong = 0.01;
  const double sigma_rad = core::Radians(0.1), yaw_rad_s = core::Radians(0.05);
  PoseTrajectory prior;
  Pose T = truth.poses().front().T;
  prior.Add(truth.poses().front().time_s, T);
  for (size_t i = 1; i < truth.poses().size(); ++i) {
    const core::StampedPose &a = truth.poses()[i - 1], &b = truth.poses()[i];
    const Pose step = a.T.inverse() * b.T;
    const double way_m = step.translation().norm(), share = std::sqrt(way_m / kEvery_m);
    mapping::Vector6 noise;
    for (int k = 0; k < 3; ++k) {
      noise[k] = kSigma_m * share * rng.Normal();
      noise[3 + k] = sigma_rad * share * rng.Normal();
    }
    noise[0] += kTooLong * way_m;
    noise[5] += yaw_rad_s * (b.time_s - a.time_s);
    T = mapping::Perturbed(T * step, noise);
    prior.Add(b.time_s, T);
  }
  return prior;
}

/// The poses of `all` from a little before to a little after a revolution.
PoseTrajectory Within(const PoseTrajectory& all, double from_s, double to_s, size_t* first) {
  constexpr double kMargin_s = 0.006;
  const auto& poses = all.poses();
  while (*first + 1 < poses.size() && poses[*first + 1].time_s <= from_s - kMargin_s) ++*first;
  PoseTrajectory part;
  for (size_t i = *first; i < poses.size() && poses[i].time_s <= to_s + kMargin_s; ++i)
    part.Add(poses[i].time_s, poses[i].T);
  return part;
}

TextTable OdometryRows(const std::vector<OdometryCase>& cases) {
  TextTable table{
      {"scene", "LiDAR", "prior", "way m", "scans", "10 m %", "deg/m", "100 m %", "deg/m", "prior 10 m %",
       "prior 100 m %", "end m", "lost", "degenerate", "CPU ms a scan"},
      {true, true, true, false, false, false, false, false, false, false, false, false, false, false, false},
      {},
      {}};
  const auto percent = [](const std::vector<WindowDrift>& drift, size_t k) {
    return k < drift.size() && drift[k].windows > 0 ? fmt::format("{:.3f}", drift[k].percent)
                                                    : std::string("-");
  };
  const auto turn = [](const std::vector<WindowDrift>& drift, size_t k) {
    return drift[k].windows > 0 ? fmt::format("{:.4f}", drift[k].deg_per_m) : std::string("-");
  };
  for (const OdometryCase& c : cases) {
    table.rows.push_back(
        {c.scene, c.lidar, c.prior, fmt::format("{:.1f}", c.way_m), fmt::format("{}", c.scans),
         percent(c.drift, 0), turn(c.drift, 0), percent(c.drift, 1), turn(c.drift, 1),
         percent(c.prior_drift, 0), percent(c.prior_drift, 1), fmt::format("{:.3f}", c.end_error_m),
         fmt::format("{}", c.lost), fmt::format("{}", c.degenerate), fmt::format("{:.1f}", c.ms_a_scan)});
  }
  table.notes = {
      "Mean error of relative poses over windows of 10 and 100 m of way, of their length; one thread.",
      "Thesis and best public odometry: 0.30 % over 100 m, 0.97 % over 10 m."};
  return table;
}

}  // namespace

WindowDrift DriftOver(double length_m, const std::vector<Pose>& truth, const std::vector<Pose>& estimate,
                      size_t stride) {
  WindowDrift drift{length_m, 0, 0.0, 0.0};
  std::vector<double> way_m(truth.size(), 0.0);
  for (size_t i = 1; i < truth.size(); ++i)
    way_m[i] = way_m[i - 1] + (truth[i].translation() - truth[i - 1].translation()).norm();
  for (size_t i = 0, j = 0; i < truth.size(); i += stride) {
    while (j < truth.size() && way_m[j] - way_m[i] < length_m) ++j;
    if (j >= truth.size()) break;
    const Pose error = (truth[i].inverse() * truth[j]).inverse() * (estimate[i].inverse() * estimate[j]);
    drift.percent += 100.0 * error.translation().norm() / length_m;
    drift.deg_per_m += core::Degrees(TurnOf(error)) / length_m;
    ++drift.windows;
  }
  const auto windows = static_cast<double>(std::max<size_t>(drift.windows, 1));
  drift.percent /= windows;
  drift.deg_per_m /= windows;
  return drift;
}

OdometryCase RunOdometryCase(const std::string& scene, const std::string& lidar, bool with_prior,
                             int max_scans, int threads, const std::function<void(double)>& progress) {
  RecordOptions options;
  options.scene = scene;
  options.lidar = lidar;
  options.rate_hz = kRate_hz;
  options.threads = threads;
  DatasetRecorder recorder(options);
  const PoseTrajectory prior = BiasedPrior(recorder.trajectory(), core::Rng(1).Split("odometry_prior"));
  OdometryCase result;
  result.scene = scene;
  result.lidar = lidar;
  result.prior = with_prior ? "biased" : "none";
  const size_t all = recorder.stamps_s().size();
  result.scans = max_scans > 0 ? std::min(all, static_cast<size_t>(max_scans)) : all;
  mapping::LidarOdometry odometry({});
  std::vector<Pose> truth, estimate, told;
  double seconds = 0.0;
  size_t first = 0;
  core::SpinEvent spin;
  while (truth.size() < result.scans && recorder.Next(&spin)) {
    const PoseTrajectory true_poses = spin.T_odom_lidar;
    spin.T_odom_lidar = Within(prior, spin.scan.stamp_s, spin.scan.stamp_s + 1.0 / kRate_hz, &first);
    const double before_s = core::CpuSeconds();
    const mapping::LidarOdometryResult found = with_prior ? odometry.Add(spin) : odometry.Add(spin.scan);
    seconds += core::CpuSeconds() - before_s;
    // Without a prior a scan tells the pose at its middle.
    const double at_s = with_prior ? found.time_s : 0.5 * (spin.scan.stamp_s + found.time_s);
    truth.push_back(true_poses.At(at_s));
    estimate.push_back(found.trajectory.At(at_s));
    told.push_back(spin.T_odom_lidar.At(at_s));
    result.degenerate += found.degenerate;
    result.lost += truth.size() > 1 && !found.tracked;
    progress(static_cast<double>(truth.size()) / static_cast<double>(result.scans));
  }
  for (size_t i = 1; i < truth.size(); ++i)
    result.way_m += (truth[i].translation() - truth[i - 1].translation()).norm();
  result.ms_a_scan = 1e3 * seconds / static_cast<double>(std::max<size_t>(truth.size(), 1));
  const Pose moved = truth.front().inverse() * truth.back(),
             found = estimate.front().inverse() * estimate.back();
  result.end_error_m = (moved.inverse() * found).translation().norm();
  for (const double length_m : {10.0, 100.0}) {
    result.drift.push_back(DriftOver(length_m, truth, estimate, kWindowStride));
    if (with_prior) result.prior_drift.push_back(DriftOver(length_m, truth, told, kWindowStride));
  }
  return result;
}

std::string OdometryTable(const std::vector<OdometryCase>& cases) {
  return ToTerminal(OdometryRows(cases));
}

void WriteOdometryBench(const std::filesystem::path& folder, const std::vector<OdometryCase>& cases) {
  core::WriteFileAtomically(folder / "odometry.md", ToMarkdown(OdometryRows(cases)));
  core::WriteFileAtomically(folder / "odometry.csv", ToCsv(OdometryRows(cases)));
}

}  // namespace atlas::experiments
