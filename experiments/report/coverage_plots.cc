#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/report/report.h"
#include "experiments/results/statistics.h"

namespace atlas::experiments {
namespace {

using Along = std::vector<double> CoverageCurve::*;

/// The curve's last value at or before x; NaN before the first scan.
double ValueAt(const CoverageCurve& curve, Along along, double x, double scale) {
  const std::vector<double>& xs = curve.*along;
  const auto after = std::upper_bound(xs.begin(), xs.end(), x / scale + 1e-9);
  if (after == xs.begin()) return std::numeric_limits<double>::quiet_NaN();
  return 100.0 * curve.coverage[static_cast<size_t>(after - xs.begin()) - 1];
}

/// Mean and spread of the runs' curves at each of `grid`.
PlotSeries MeanSeries(const std::string& label, const std::vector<const CoverageCurve*>& curves, Along along,
                      const std::vector<double>& grid, double scale) {
  PlotSeries series{.label = label};
  for (const double x : grid) {
    std::vector<double> values;
    for (const CoverageCurve* curve : curves) values.push_back(ValueAt(*curve, along, x, scale));
    if (std::any_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) continue;
    const SampleStatistics s = Describe(values);
    series.x.push_back(x);
    series.y.push_back(s.mean);
    if (curves.size() > 1) {
      series.y_low.push_back(s.min);
      series.y_high.push_back(s.max);
    }
  }
  return series;
}

/// A curve for each group of the object that was drawn anything.
struct GroupCurves {
  std::string label;
  std::vector<const CoverageCurve*> curves;
};
std::vector<GroupCurves> CurvesOf(const std::string& object, const std::vector<RunGroup>& groups) {
  std::vector<GroupCurves> all;
  for (const RunGroup& group : groups) {
    if (group.object != object) continue;
    GroupCurves curves{group.gain + ", " + group.Method(), {}};
    for (const ReportedRun& run : group.runs) {
      if (!run.curve.scan.empty()) curves.curves.push_back(&run.curve);
    }
    if (!curves.curves.empty()) all.push_back(std::move(curves));
  }
  return all;
}

}  // namespace

std::string CoverageByScanPlot(const std::string& object, const std::vector<RunGroup>& groups) {
  std::vector<PlotSeries> series;
  for (const auto& [label, curves] : CurvesOf(object, groups)) {
    double last = 1.0;
    for (const CoverageCurve* curve : curves) last = std::max(last, curve->scan.back());
    std::vector<double> grid;
    for (double scan = 1.0; scan <= last; scan += 1.0) grid.push_back(scan);
    series.push_back(MeanSeries(label, curves, &CoverageCurve::scan, grid, 1.0));
  }
  return PlotSvg(series, {.title = object + ": coverage per scan",
                          .x_label = "scan",
                          .y_label = "point cloud coverage (%)",
                          .x_range = std::nullopt,
                          .y_range = std::pair(0.0, 100.0),
                          .integer_x = true});
}

std::string CoverageByTimePlot(const std::string& object, const std::vector<RunGroup>& groups) {
  constexpr double kStepMin = 0.1, kMinutesPerSecond = 1.0 / 60.0;
  std::vector<PlotSeries> series;
  for (const auto& [label, curves] : CurvesOf(object, groups)) {
    double last_min = kStepMin;
    for (const CoverageCurve* curve : curves)
      last_min = std::max(last_min, kMinutesPerSecond * curve->sim_time_s.back());
    std::vector<double> grid;
    for (double t = 0.0; t < last_min + kStepMin; t += kStepMin) grid.push_back(t);
    PlotSeries mean = MeanSeries(label, curves, &CoverageCurve::sim_time_s, grid, kMinutesPerSecond);
    mean.markers = false;
    series.push_back(std::move(mean));
  }
  return PlotSvg(series, {.title = object + ": coverage over simulated time",
                          .x_label = "simulated time (min)",
                          .y_label = "point cloud coverage (%)",
                          .x_range = std::nullopt,
                          .y_range = std::pair(0.0, 100.0)});
}

}  // namespace atlas::experiments
