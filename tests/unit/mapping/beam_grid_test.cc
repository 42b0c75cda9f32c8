// Rows of directions against plain interpolation between the beams' elevations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/errors.h"
#include "mapping/integrator/projection/project-inl.h"

namespace atlas::mapping {
namespace {

double RowAt(const BeamGrid& grid, double elevation) {
  const HWY_NAMESPACE::DF d;
  const auto sine = HWY_NAMESPACE::hn::Set(d, static_cast<float>(std::sin(elevation)));
  return static_cast<double>(HWY_NAMESPACE::hn::GetLane(HWY_NAMESPACE::RowOf(d, grid, sine)));
}

/// The greatest error over elevations within the rows, in rows.
double WorstRow(const core::LidarModel& lidar) {
  const BeamGrid grid = MakeBeamGrid(lidar);
  std::vector<double> beams = lidar.elevation_rad;
  std::sort(beams.rbegin(), beams.rend());
  double worst = 0.0;
  for (size_t row = 0; row + 1 < beams.size(); ++row) {
    for (const double w : {0.0, 0.2, 0.5, 0.9}) {
      const double error =
          RowAt(grid, beams[row] + w * (beams[row + 1] - beams[row])) - (static_cast<double>(row) + w);
      worst = std::max(worst, std::abs(error));
    }
  }
  return worst;
}

TEST(BeamGrid, RowsOfEvenBeamsFollowAPolynomial) {
  for (const char* name : {"os1_64", "vlp16"}) {
    const core::LidarModel lidar = core::FindLidarModel(name);
    EXPECT_TRUE(MakeBeamGrid(lidar).polynomial) << name;
    EXPECT_LT(WorstRow(lidar), 1.1 * BeamGrid::kWorstFit) << name;
  }
}

TEST(BeamGrid, RowsOfUnevenBeamsComeFromTheTable) {
  core::LidarModel lidar = core::FindLidarModel("os1_64");
  for (double& elevation : lidar.elevation_rad) elevation += 0.004 * std::sin(40.0 * elevation);
  EXPECT_FALSE(MakeBeamGrid(lidar).polynomial);
  EXPECT_LT(WorstRow(lidar), 0.02);
}

TEST(BeamGrid, RowsGoOnGrowingEvenlyBeyondTheGrid) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  const BeamGrid grid = MakeBeamGrid(lidar);
  const double pitch = grid.mean_row_pitch_rad;
  const auto [lowest, highest] = std::minmax_element(lidar.elevation_rad.begin(), lidar.elevation_rad.end());
  EXPECT_NEAR(RowAt(grid, *highest + 0.1), -0.1 / pitch, 0.05);
  EXPECT_NEAR(RowAt(grid, *lowest - 0.1), grid.rows - 1 + 0.1 / pitch, 0.05);
  EXPECT_LT(RowAt(grid, *highest + 0.5), -0.1 / pitch);
  EXPECT_GT(RowAt(grid, *lowest - 0.5), grid.rows - 1 + 0.1 / pitch);
}

TEST(BeamGrid, MoreCellsThanImagesIndexAreRefused) {
  core::LidarModel lidar = core::FindLidarModel("os1_64");
  lidar.elevation_rad.resize(1024);
  lidar.azimuth_offset_rad.assign(1024, 0.0);
  for (size_t row = 0; row < 1024; ++row) lidar.elevation_rad[row] = 0.4 - 0.0007 * static_cast<double>(row);
  lidar.columns = 8192;
  EXPECT_EQ(MakeBeamGrid(lidar).columns, 8192);
  lidar.columns = 8193;
  EXPECT_THROW(MakeBeamGrid(lidar), core::InputError);
}

}  // namespace
}  // namespace atlas::mapping
