// Stage 1a, projection: the undistorted rays of a revolution, and the cell of the beam grid that each falls
// into. Both are gone once cells have chosen (range_image.h); their memory is lent (scan_memory.h).
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/integrator/projection/grid_columns.h"
#include "mapping/integrator/projection/scan_poses.h"

namespace atlas::mapping {

/// Rays in the LiDAR frame at the middle of the scan, rows of the scan by ascending azimuth. range > 0: a
/// return at (x, y, z); < 0: nothing met up to -range, (x, y, z) a unit direction; 0: no information.
struct RayBundle {
  size_t count = 0;  ///< the vectors may be longer
  std::vector<float> x, y, z, range;
  std::vector<float> u, v;  ///< grid coordinates; u < 0: no direction either
};

/// Of the rays that fall into a cell of the grid, the one nearest to its middle; a column of margin repeats
/// the other end of each row.
struct RayBins {
  size_t pitch = 0, count = 0;  ///< columns + 2, and that times rows
  std::vector<float> du, dv;    ///< of the ray against the cell's middle, cells; du of an empty bin: 1e9
  std::vector<int32_t> ray;
  std::vector<uint8_t> taken;  ///< a ray each: a cell took it, or none that is filled could
};

/// What rays are projected from, and onto.
struct RaySource {
  const core::LidarScan& scan;
  const ColumnPoses& poses;
  const ImageOptions& options;
  const BeamGrid& grid;
};

/// Projects every ray to where it points from the middle of the scan.
void ProjectScan(const RaySource& source, RayBundle* rays);
void BinRays(const GridColumns& grid, const RayBundle& rays, RayBins* bins);

}  // namespace atlas::mapping
