// Beams from points. With hits of pixel (row, column) at elevation e and azimuth a:
//   step   median of a(column + lag) - a(column) over all hits, by lags 1, 2, 4, ..., each resolving the
//   turns of
//          the next, so that the last has the precision of half a revolution;
//   phase  of a row: median on the circle of a - step * column;
//   e      of a row: its median.
#include <fmt/format.h>

#include <algorithm>

#include "core/errors.h"
#include "mapping/io/beam_fit.h"

namespace atlas::mapping {
namespace {

using core::InputError;
using core::WrapAngle;

constexpr int kLeastRows = 2, kLeastColumns = 16;
constexpr size_t kLeastHitsOfRow = 8;
/// Residuals above which the points are not those of a spinning LiDAR in its own frame.
constexpr double kElevationLimit_rad = core::Radians(0.3);
constexpr double kAzimuthLimit_rad = core::Radians(1.5);

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<long>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

double CircularMean(const std::vector<double>& angles) {
  double c = 0.0, s = 0.0;
  for (const double a : angles) {
    c += std::cos(a);
    s += std::sin(a);
  }
  return std::atan2(s, c);
}

/// The middle one of angles that lie on less than the whole circle, apart from outliers.
double CircularMedian(std::vector<double> angles) {
  double centre = CircularMean(angles);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> off;
    off.reserve(angles.size());
    for (const double a : angles) off.push_back(WrapAngle(a - centre));
    centre += Median(&off);
  }
  return WrapAngle(centre);
}

/// The median step over pairs of hits `lag` columns apart, given the step to within half a turn over the lag.
std::optional<double> StepAtLag(const std::vector<HitAngles>& scans, int rows, int columns, int lag,
                                double step) {
  std::vector<double> deviations;
  for (const HitAngles& scan : scans) {
    for (int row = 0; row < rows; ++row) {
      const float* azimuth = scan.azimuth.data() + static_cast<long>(row) * columns;
      for (int c = 0; c + lag < columns; ++c) {
        const double difference = static_cast<double>(azimuth[c + lag]) - static_cast<double>(azimuth[c]);
        if (std::isfinite(difference)) deviations.push_back(WrapAngle(difference - lag * step));
      }
    }
  }
  if (deviations.size() < kLeastHitsOfRow) return std::nullopt;
  return step + Median(&deviations) / lag;
}

double EstimateStep(const std::vector<HitAngles>& scans, int rows, int columns, const std::string& what) {
  double step = 0.0;
  for (int lag = 1; lag <= columns / 2; lag *= 2) {
    const auto refined = StepAtLag(scans, rows, columns, lag, step);
    if (refined) step = *refined;
    if (!refined && lag == 1)
      throw InputError(fmt::format("{}: too few returns side by side to tell the beams", what));
  }
  const double full = std::copysign(2.0 * core::kPi / columns, step);
  if (std::abs(step - full) * columns < 0.5 * std::abs(full)) return full;
  return step;
}

/// Rows without a measurement, by their neighbours.
void FillRows(const std::vector<bool>& measured, core::LidarModel* model) {
  const int rows = model->rows();
  std::vector<int> known;
  for (int r = 0; r < rows; ++r) {
    if (measured[static_cast<size_t>(r)]) known.push_back(r);
  }
  const auto elevation = [&](int r) -> double& { return model->elevation_rad[static_cast<size_t>(r)]; };
  const auto offset = [&](int r) -> double& { return model->azimuth_offset_rad[static_cast<size_t>(r)]; };
  for (int r = 0; r < rows; ++r) {
    if (measured[static_cast<size_t>(r)]) continue;
    const auto above = std::lower_bound(known.begin(), known.end(), r);
    auto second = above == known.end() ? known.end() - 1 : above == known.begin() ? known.begin() + 1 : above;
    const int a = *(second - 1), b = *second;
    elevation(r) = elevation(a) + (elevation(b) - elevation(a)) * (r - a) / (b - a);
    int nearest = -1;  // beams side by side repeat every four rows
    for (const int k : known) {
      if ((k - r) % 4 == 0 && (nearest < 0 || std::abs(k - r) < std::abs(nearest - r))) nearest = k;
    }
    offset(r) = nearest >= 0 ? offset(nearest) : 0.0;
  }
}

void CheckShape(const std::vector<RecordedCloud>& clouds, const std::string& what) {
  if (clouds.empty()) throw InputError(fmt::format("{}: no cloud to tell the beams from", what));
  for (const RecordedCloud& cloud : clouds) {
    if (!cloud.organised || cloud.rows < kLeastRows || cloud.columns < kLeastColumns) {
      throw InputError(
          fmt::format("{}: {} x {} points are no organised LiDAR scan (at least {} rows and {} columns)",
                      what, cloud.rows, cloud.columns, kLeastRows, kLeastColumns));
    }
    if (cloud.rows != clouds[0].rows || cloud.columns != clouds[0].columns) {
      throw InputError(fmt::format("{}: scans of {} x {} and {} x {} points in one log", what, clouds[0].rows,
                                   clouds[0].columns, cloud.rows, cloud.columns));
    }
  }
}

}  // namespace

std::vector<HitAngles> AnglesOf(const std::vector<RecordedCloud>& clouds) {
  std::vector<HitAngles> scans;
  for (const RecordedCloud& cloud : clouds) {
    HitAngles scan;
    for (const core::Vec3f& p : cloud.p_lidar) {
      const float horizontal = std::hypot(p.x(), p.y());
      scan.azimuth.push_back(std::atan2(p.y(), p.x()));
      scan.elevation.push_back(std::atan2(p.z(), horizontal));
    }
    scans.push_back(std::move(scan));
  }
  return scans;
}

void MeasureResiduals(const std::vector<HitAngles>& scans, BeamFit* fit) {
  std::vector<double> elevation, azimuth;
  const core::LidarModel& model = fit->model;
  for (const HitAngles& scan : scans) {
    for (size_t i = 0; i < scan.azimuth.size(); ++i) {
      if (!std::isfinite(scan.azimuth[i])) continue;
      const int row = static_cast<int>(i) / model.columns, column = static_cast<int>(i) % model.columns;
      const double e = model.elevation_rad[static_cast<size_t>(row)];
      const double off = WrapAngle(static_cast<double>(scan.azimuth[i]) - model.AzimuthRad(row, column));
      elevation.push_back(std::abs(static_cast<double>(scan.elevation[i]) - e));
      azimuth.push_back(std::abs(off));
    }
  }
  fit->elevation_residual_rad = Median(&elevation);
  fit->azimuth_residual_rad = Median(&azimuth);
}

MeasuredRows MeasureRows(const std::vector<HitAngles>& scans, int rows, int columns, double step) {
  MeasuredRows out;
  for (int row = 0; row < rows; ++row) {
    std::vector<double> elevation, phase;
    for (const HitAngles& scan : scans) {
      for (int c = 0; c < columns; ++c) {
        const auto i = static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(c);
        if (!std::isfinite(scan.azimuth[i])) continue;
        elevation.push_back(static_cast<double>(scan.elevation[i]));
        phase.push_back(static_cast<double>(scan.azimuth[i]) - step * c);
      }
    }
    const bool enough = elevation.size() >= kLeastHitsOfRow;
    out.measured.push_back(enough);
    out.elevation_rad.push_back(enough ? Median(&elevation) : 0.0);
    out.phase_rad.push_back(enough ? CircularMedian(phase) : 0.0);
  }
  return out;
}

double CommonPhase(const MeasuredRows& rows, const std::vector<double>& offset_rad) {
  std::vector<double> phases;
  for (size_t r = 0; r < rows.measured.size(); ++r) {
    if (rows.measured[r]) phases.push_back(rows.phase_rad[r] - offset_rad[r]);
  }
  return CircularMean(phases);
}

BeamFit EstimateBeams(const std::vector<RecordedCloud>& clouds, const std::string& what) {
  CheckShape(clouds, what);
  const int rows = clouds[0].rows, columns = clouds[0].columns;
  const std::vector<HitAngles> scans = AnglesOf(clouds);
  BeamFit fit;
  core::LidarModel& model = fit.model;
  model.name = "estimated";
  model.columns = columns;
  model.column_step_rad = EstimateStep(scans, rows, columns, what);
  fit.counter_clockwise = model.column_step_rad > 0.0;
  const MeasuredRows measured = MeasureRows(scans, rows, columns, model.column_step_rad);
  fit.measured_rows = static_cast<int>(std::count(measured.measured.begin(), measured.measured.end(), true));
  if (fit.measured_rows < std::max(2, rows / 4))
    throw InputError(fmt::format("{}: only {} of {} rows have returns enough to tell the beams", what,
                                 fit.measured_rows, rows));
  model.elevation_rad = measured.elevation_rad;
  model.first_azimuth_rad = CommonPhase(measured, std::vector<double>(measured.measured.size(), 0.0));
  for (const double phase : measured.phase_rad)
    model.azimuth_offset_rad.push_back(WrapAngle(phase - model.first_azimuth_rad));
  FillRows(measured.measured, &model);
  MeasureResiduals(scans, &fit);
  const double azimuth_limit = std::max(kAzimuthLimit_rad, 2.0 * std::abs(model.column_step_rad));
  if (fit.elevation_residual_rad > kElevationLimit_rad || fit.azimuth_residual_rad > azimuth_limit) {
    throw InputError(
        fmt::format("{}: not the scan of a spinning LiDAR in its own frame: off its rows by {:.2f} deg "
                    "(limit {:.2f}), off its "
                    "columns by {:.2f} deg (limit {:.2f})",
                    what, core::Degrees(fit.elevation_residual_rad), core::Degrees(kElevationLimit_rad),
                    core::Degrees(fit.azimuth_residual_rad), core::Degrees(azimuth_limit)));
  }
  return fit;
}

}  // namespace atlas::mapping
