// Stage 2, measurement: the plane of the surface through each return of the range image.
#pragma once

#include <vector>

#include "mapping/integrator/projection/range_image.h"

namespace atlas::mapping {

struct SurfaceImage {
  const RangeImage* image;  ///< the returns
  /// Cells with a return: unit normal towards the sensor (LiDAR frame) and, with reach_behind_m,
  /// 1 / cos(incidence).
  std::vector<float> nx, ny, nz, inverse_cos;

  explicit SurfaceImage(const RangeImage& of) : image(&of), inverse_cos(of.cells()) {}
};

}  // namespace atlas::mapping
