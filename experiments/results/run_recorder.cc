#include "experiments/results/run_recorder.h"

#include <fmt/format.h>

#include <utility>

#include "core/files.h"
#include "experiments/results/run_files.h"
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

std::string CoveragePicture(const std::vector<core::Row>& steps, const RunSummary& summary) {
  std::vector<PlotSeries> series;
  for (const PictureCurve& curve : kPictureCurves) {
    PlotSeries drawn{.label = curve.label};
    for (const core::Row& step : steps) {
      const auto share = step.Number(curve.column);
      if (!share) continue;
      drawn.x.push_back(step.Number("scan").value_or(0.0));
      drawn.y.push_back(100.0 * *share);
    }
    if (!drawn.x.empty() || steps.empty()) series.push_back(std::move(drawn));
  }
  if (const auto most = summary.Number(kPictureCeiling.column); most && !steps.empty()) {
    PlotSeries ceiling{.label = kPictureCeiling.label, .dashed = true, .markers = false};
    ceiling.x = {1.0, static_cast<double>(std::max<size_t>(steps.size(), 2))};
    ceiling.y = {100.0 * *most, 100.0 * *most};
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

RunRecorder::RunRecorder(const std::filesystem::path& folder, const RunSummary& identity, RunColumns columns)
    : folder_(folder),
      summary_(identity),
      columns_(std::move(columns)),
      steps_csv_(core::CsvHeader(columns_.steps)),
      timings_csv_(core::CsvHeader(columns_.times)) {
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

void RunRecorder::AddDecision(int scan, const planner::DecisionLog& log,
                              const std::vector<std::string>& extra_gains) {
  if (candidates_csv_.empty()) candidates_csv_ = CandidatesCsvHeader(extra_gains);
  AppendCandidateRows(scan, log, extra_gains.size(), &candidates_csv_);
}

void RunRecorder::AddStep(const core::Row& step, const core::Row& times) {
  steps_.push_back(step);
  steps_csv_ += core::CsvLine(columns_.steps, step);
  timings_csv_ += core::CsvLine(columns_.times, times);
  Write();
}

const RunSummary& RunRecorder::Finish(RunStatus status, StopReason reason) {
  const RunSummary before = summary_;
  summary_.status = status;
  summary_.stop_reason = reason;
  try {
    Write();
  } catch (...) {
    summary_ = before;
    throw;
  }
  finished_ = true;
  return summary_;
}

void RunRecorder::Write() const {
  core::WriteFileAtomically(folder_ / "steps.csv", steps_csv_);
  core::WriteFileAtomically(folder_ / "timings.csv", timings_csv_);
  core::WriteFileAtomically(folder_ / "candidates.csv",
                            candidates_csv_.empty() ? CandidatesCsvHeader({}) : candidates_csv_);
  core::WriteFileAtomically(folder_ / "trajectory_truth.tum", truth_tum_);
  core::WriteFileAtomically(folder_ / "trajectory_odom.tum", odom_tum_);
  core::WriteFileAtomically(folder_ / "coverage.svg", CoveragePicture(steps_, summary_));
  core::WriteFileAtomically(folder_ / "summary.json", ToJson(summary_));
}

}  // namespace atlas::experiments
