#include "experiments/results/run_recorder.h"

#include <fmt/format.h>

#include <cmath>

#include "core/files.h"
#include "core/resource_use.h"
#include "experiments/results/run_files.h"
#include "experiments/results/statistics.h"
#include "experiments/results/svg_plot.h"

namespace atlas::experiments {
namespace {

std::string TumLine(double time_s, const core::Pose& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  const core::Vec3& p = T.translation();
  return fmt::format("{:.4f} {:.6f} {:.6f} {:.6f} {:.7f} {:.7f} {:.7f} {:.7f}\n", time_s, p.x(), p.y(), p.z(),
                     q.x(), q.y(), q.z(), q.w());
}

/// Simulated time of the first scan whose share of the attainable reached `share`.
std::optional<double> TimeToReach(const std::vector<StepRow>& steps, double share) {
  for (const StepRow& step : steps) {
    if (step.coverage_of_attainable && *step.coverage_of_attainable >= share) return step.sim_time_s;
  }
  return std::nullopt;
}

std::string CoveragePicture(const std::vector<StepRow>& steps, const RunSummary& summary) {
  PlotSeries aligned{.label = "coverage (Eq. 3.9)"}, outer{.label = "from the outer side"},
      share{.label = "share of the attainable"};
  PlotSeries ceiling{.label = "attainable", .dashed = true, .markers = false};
  for (const StepRow& step : steps) {
    aligned.x.push_back(step.scan);
    aligned.y.push_back(100.0 * step.coverage);
    outer.x.push_back(step.scan);
    outer.y.push_back(100.0 * step.coverage_outer);
    if (step.coverage_of_attainable) {
      share.x.push_back(step.scan);
      share.y.push_back(100.0 * *step.coverage_of_attainable);
    }
  }
  std::vector<PlotSeries> series = {aligned, outer};
  if (!share.x.empty()) series.push_back(share);
  if (summary.coverage_attainable && !steps.empty()) {
    ceiling.x = {1.0, static_cast<double>(std::max<size_t>(steps.size(), 2))};
    ceiling.y = {100.0 * *summary.coverage_attainable, 100.0 * *summary.coverage_attainable};
    series.push_back(ceiling);
  }
  return PlotSvg(series, {.title = fmt::format("{} · {} · {} · seed {}", summary.experiment, summary.gain,
                                               summary.planner, summary.seed),
                          .x_label = "scan",
                          .y_label = "point cloud coverage (%)",
                          .x_range = std::nullopt,
                          .y_range = std::pair(0.0, 100.0),
                          .integer_x = true});
}

}  // namespace

RunRecorder::RunRecorder(const std::filesystem::path& folder, const RunSummary& identity)
    : folder_(folder), summary_(identity) {
  summary_.status = RunStatus::kInterrupted;
  summary_.stop_reason = StopReason::kSignal;
  Write();
}

RunRecorder::~RunRecorder() {
  if (finished_ || std::uncaught_exceptions() <= exceptions_) return;
  summary_.status = RunStatus::kFailed;
  summary_.stop_reason = StopReason::kError;
  try {
    core::WriteFileAtomically(folder_ / "summary.json", ToJson(summary_));
  } catch (const std::exception&) {
    // What stands there says `interrupted`.
  }
}

void RunRecorder::AddPose(double time_s, const core::Pose& T_map_base_true, const core::Pose& T_odom_base) {
  truth_tum_ += TumLine(time_s, T_map_base_true);
  odom_tum_ += TumLine(time_s, T_odom_base);
}

void RunRecorder::AddDecision(int scan, const planner::NbvDecision& decision,
                              const std::vector<std::string>& extra_gains) {
  if (candidates_csv_.empty()) candidates_csv_ = CandidatesCsvHeader(extra_gains);
  AppendCandidateRows(scan, decision, extra_gains.size(), &candidates_csv_);
}

void RunRecorder::AddStep(const StepRow& step, const TimingRow& timing) {
  steps_.push_back(step);
  timings_.push_back(timing);
  summary_.travel_distance_m = step.distance_m;
  summary_.sim_time_s = step.sim_time_s;
  summary_.wall_time_s = timing.wall_time_s;
  Summarise();
  Write();
}

const RunSummary& RunRecorder::Finish(RunStatus status, StopReason reason, double sim_time_s,
                                      double distance_m, double wall_time_s) {
  summary_.status = status;
  summary_.stop_reason = reason;
  summary_.sim_time_s = sim_time_s;
  summary_.travel_distance_m = distance_m;
  summary_.wall_time_s = wall_time_s;
  Summarise();
  Write();
  finished_ = true;
  return summary_;
}

void RunRecorder::Summarise() {
  summary_.scans = static_cast<double>(steps_.size());
  if (summary_.wall_time_s && *summary_.wall_time_s > 0.0) {
    summary_.real_time_factor = summary_.sim_time_s.value_or(0.0) / *summary_.wall_time_s;
  }
  summary_.peak_rss_bytes = core::PeakResidentBytes();
  if (steps_.empty()) return;

  const StepRow& last = steps_.back();
  summary_.coverage = last.coverage;
  summary_.coverage_raw = last.coverage_raw;
  summary_.coverage_outer = last.coverage_outer;
  summary_.coverage_of_attainable = last.coverage_of_attainable;
  if (last.falls) summary_.falls = std::max<double>(summary_.falls.value_or(0.0), *last.falls);
  if (last.collisions) {
    summary_.collisions = std::max<double>(summary_.collisions.value_or(0.0), *last.collisions);
  }
  summary_.flat_by_truth = last.flat_by_truth;
  summary_.t50_s = TimeToReach(steps_, 0.50);
  summary_.t90_s = TimeToReach(steps_, 0.90);
  summary_.t95_s = TimeToReach(steps_, 0.95);

  std::vector<double> nbv_s, integration_ms;
  for (const TimingRow& row : timings_) {
    if (row.nbv_time_s > 0.0) nbv_s.push_back(row.nbv_time_s);
    integration_ms.push_back(row.integration_ms);
  }
  if (!nbv_s.empty()) {
    summary_.nbv_time_s_mean = Describe(nbv_s).mean;
    summary_.nbv_time_s_p95 = Percentile(nbv_s, 0.95);
  }
  summary_.integration_ms_mean = Describe(integration_ms).mean;
  summary_.integration_ms_p95 = Percentile(integration_ms, 0.95);
  summary_.map_bytes = static_cast<double>(timings_.back().map_bytes);
}

void RunRecorder::Write() const {
  core::WriteFileAtomically(folder_ / "steps.csv", StepsCsv(steps_));
  core::WriteFileAtomically(folder_ / "timings.csv", TimingsCsv(timings_));
  core::WriteFileAtomically(folder_ / "candidates.csv",
                            candidates_csv_.empty() ? CandidatesCsvHeader({}) : candidates_csv_);
  core::WriteFileAtomically(folder_ / "trajectory_truth.tum", truth_tum_);
  core::WriteFileAtomically(folder_ / "trajectory_odom.tum", odom_tum_);
  core::WriteFileAtomically(folder_ / "coverage.svg", CoveragePicture(steps_, summary_));
  core::WriteFileAtomically(folder_ / "summary.json", ToJson(summary_));
}

}  // namespace atlas::experiments
