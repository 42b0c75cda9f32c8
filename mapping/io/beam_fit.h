// The measurements that estimating beams and fitting a table to them share.
#pragma once

#include <string>
#include <vector>

#include "mapping/io/beam_table.h"

namespace atlas::mapping {

/// Angles of each pixel of a scan; NaN without a return.
struct HitAngles {
  std::vector<float> azimuth, elevation;
};
std::vector<HitAngles> AnglesOf(const std::vector<RecordedCloud>& clouds);

/// Medians over the hits of each row; phase = azimuth - step * column.
struct MeasuredRows {
  std::vector<bool> measured;  ///< enough hits
  std::vector<double> elevation_rad, phase_rad;
};
MeasuredRows MeasureRows(const std::vector<HitAngles>& scans, int rows, int columns, double step_rad);

/// The mean on the circle of what the measured rows' phases have beyond their offsets.
double CommonPhase(const MeasuredRows& rows, const std::vector<double>& offset_rad);

/// Median distances of the hits from `fit->model`.
void MeasureResiduals(const std::vector<HitAngles>& scans, BeamFit* fit);

}  // namespace atlas::mapping
