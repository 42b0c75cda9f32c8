// Rows of directions against plain interpolation between the beams' elevations.
#include "mapping/integrator/beam_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace atlas::mapping {
namespace {

/// The greatest error over elevations within the rows, in rows.
double WorstRow(const core::LidarModel& lidar) {
  const BeamGrid grid = MakeBeamGrid(lidar);
  std::vector<double> beams = lidar.elevation_rad;
  std::sort(beams.rbegin(), beams.rend());
  double worst = 0.0;
  for (size_t row = 0; row + 1 < beams.size(); ++row) {
    for (const double w : {0.0, 0.2, 0.5, 0.9}) {
      const double sine = std::sin(beams[row] + w * (beams[row + 1] - beams[row]));
      const double error = static_cast<double>(RowOfSine(grid, static_cast<float>(sine))) - (row + w);
      worst = std::max(worst, std::abs(error));
    }
  }
  return worst;
}

TEST(BeamGrid, RowsOfEvenBeamsFollowAPolynomial) {
  for (const char* name : {"os1_64", "vlp16"}) {
    const core::LidarModel lidar = core::FindLidarModel(name);
    EXPECT_TRUE(MakeBeamGrid(lidar).even) << name;
    EXPECT_LT(WorstRow(lidar), 1.1 * BeamGrid::kEvenRows) << name;
  }
}

TEST(BeamGrid, RowsOfUnevenBeamsComeFromTheTable) {
  core::LidarModel lidar = core::FindLidarModel("os1_64");
  for (double& elevation : lidar.elevation_rad) elevation += 0.004 * std::sin(40.0 * elevation);
  EXPECT_FALSE(MakeBeamGrid(lidar).even);
  EXPECT_LT(WorstRow(lidar), 0.02);
}

TEST(BeamGrid, RowsGoOnGrowingEvenlyBeyondTheGrid) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  const BeamGrid grid = MakeBeamGrid(lidar);
  const double pitch = grid.mean_row_pitch_rad;
  const auto [lowest, highest] = std::minmax_element(lidar.elevation_rad.begin(), lidar.elevation_rad.end());
  const auto row_at = [&](double elevation) {
    return static_cast<double>(RowOfSine(grid, static_cast<float>(std::sin(elevation))));
  };
  EXPECT_NEAR(row_at(*highest + 0.1), -0.1 / pitch, 0.05);
  EXPECT_NEAR(row_at(*lowest - 0.1), grid.rows - 1 + 0.1 / pitch, 0.05);
  EXPECT_LT(row_at(*highest + 0.5), -0.1 / pitch);
  EXPECT_GT(row_at(*lowest - 0.5), grid.rows - 1 + 0.1 / pitch);
}

}  // namespace
}  // namespace atlas::mapping
