// Stage 1b, projection: the range image. Each cell of the beam grid gets the undistorted ray nearest to its
// direction (thesis 4.5.3, Fig. 4.7).
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/integrator/projection/ray_bundle.h"

namespace atlas::mapping {

/// Cells by row * columns + column.
struct RangeImage : GridColumns {
  static constexpr float kPerCell = 32768.0f;
  std::vector<int32_t> cell_ray;  ///< the matched ray of the bundle; -1: none
  std::vector<int32_t>
      offset;                  ///< its place against the cell's: columns low, rows high half, in 1 / kPerCell
  std::vector<float> range;    ///< as RayBundle
  std::vector<float> x, y, z;  ///< as RayBundle
  float reach_m = 0.0f;        ///< of the farthest cell
  /// Returns that no cell took, since another ray is nearer to each direction around.
  struct SpareHit {
    int32_t cell;  ///< that the ray falls into
    float range, end[3];
  };
  std::vector<SpareHit> spare;

  explicit RangeImage(const BeamGrid& beams);
};

/// What cells choose from.
struct RayOffers {
  const RayBundle& rays;
  const RayBins& bins;
  float stop_rad;  ///< the search for the nearest ray ends here
};

/// Matches the filled cells; marks the rays that they took.
void MatchCells(const RayBundle& rays, const ImageOptions& options, RayBins* bins, RangeImage* image);

}  // namespace atlas::mapping
