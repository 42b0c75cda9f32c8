// The ideal grid of a spinning LiDAR: a row for each beam elevation, columns evenly around the turn.
//
// Directions become grid coordinates (u, v): u counts columns by ascending azimuth in [0, columns), v counts
// rows from the highest beam downwards, -0.5 to rows - 0.5 inside, linear in the elevation between beams.
// Rows may be at any elevations: their coordinate comes from a table over the sine, or from a polynomial in
// it where that fits, as it does where the elevations are even and stay within +-30 degrees or so.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/lidar_model.h"

namespace atlas::mapping {

struct BeamGrid {
  static constexpr size_t kMostCells = size_t{1}
                                       << 23;  ///< images, with their margins, are indexed by floats
  int rows = 0;
  int columns = 0;
  double column_pitch_rad = 0.0;
  double phase_rad = 0.0;      ///< azimuth of column 0, in [-pi, -pi + pitch)
  bool clockwise = false;      ///< scans run against the columns, seen from above
  double min_pitch_rad = 0.0;  ///< least angle between neighbouring beams: opening of their cones (4.5.1)
  double mean_row_pitch_rad = 0.0;
  std::vector<float> elevation_rad;  ///< a row each, descending
  std::vector<float> row_pitch_rad;  ///< a row each: mean of the angles to its neighbours
  std::vector<float> cos_elevation;  ///< a row each

  float sin_min = 0.0f, sin_max = 0.0f;  ///< rows go on growing evenly outside the grid from here to there
  /// Where `polynomial`: row = row_of_level + the sum of row_terms[i] * sine^(2 i + 1), within kWorstFit
  /// rows.
  static constexpr double kWorstFit = 2e-3;
  bool polynomial = false;
  float row_of_level = 0.0f;
  std::array<float, 5> row_terms{};
  static constexpr int kTableIntervals = 4096;
  float intervals_per_sin = 0.0f;
  std::vector<float> row_of_sin;  ///< kTableIntervals + 1 knots from sin_min
};

/// @throws InputError for fewer than 2 rows or 16 columns, more than 1024, 16384 or kMostCells in all, or
/// elevations that coincide or leave +-90 degrees.
BeamGrid MakeBeamGrid(const core::LidarModel& lidar);

}  // namespace atlas::mapping
