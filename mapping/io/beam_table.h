// The directions of an organised cloud's pixels: from a LiDAR's table or estimated from its points.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "mapping/io/recorded_cloud.h"

namespace atlas::mapping {

/// How well a table describes the points it was fitted to.
struct BeamFit {
  core::LidarModel model;
  double elevation_residual_rad = 0.0;  ///< median over the hits of |measured - table|
  double azimuth_residual_rad = 0.0;    ///< the same, along the horizon
  int measured_rows = 0;                ///< rows with enough hits; the others are interpolated
  bool counter_clockwise = false;       ///< seen from above
};

/// Elevation of each row, azimuth of each row and column, step and sense of rotation, by medians on the
/// circle over all hits of `clouds` (organised, of one shape). Rows without enough hits are interpolated
/// between their neighbours. @throws InputError naming `what` where the clouds are not those of a spinning
/// LiDAR: fewer than two rows or sixteen columns, too few hits, or rows whose elevation is not constant.
BeamFit EstimateBeams(const std::vector<RecordedCloud>& clouds, const std::string& what);

/// Elevations (and azimuth offsets) from `table`; the number of columns, the azimuth of the first, the sense
/// of rotation, whether row 0 is the top one, and whether columns are firings or azimuths (destaggered) from
/// the points. @throws InputError naming `what`, the row, its measured and its tabled elevation where they
/// differ by more than a degree.
BeamFit FitBeams(const core::LidarModel& table, const std::vector<RecordedCloud>& clouds,
                 const std::string& what);

/// Ouster metadata (beam_altitude_angles and beam_azimuth_angles in degrees, at the top or below
/// beam_intrinsics). @throws InputError.
core::LidarModel ReadOusterMetadata(const std::filesystem::path& path);
core::LidarModel ParseOusterMetadata(std::string_view text, const std::string& file);

}  // namespace atlas::mapping
