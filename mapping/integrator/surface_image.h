// Stage 2, measurement: the plane of the surface through each return of the range image.
#pragma once

#include <vector>

#include "mapping/integrator/range_image.h"

namespace atlas::mapping {

struct FreeSpaceTables;

struct SurfaceImage {
  const RangeImage* image;  ///< the returns
  /// Cells with a return: unit normal towards the sensor (LiDAR frame) and, with reach_behind_m,
  /// 1 / cos(incidence).
  std::vector<float> nx, ny, nz, inverse_cos;

  explicit SurfaceImage(const RangeImage& of) : image(&of), inverse_cos(of.cells()) {}
};

/// What one pass over the returns fills: the planes, and of the tables the margins `own` and `surround`.
struct PlanesOut {
  SurfaceImage* surface;
  FreeSpaceTables* tables;
};
/// @param rotation_map_lidar  for the voxel's support along normals.
void FindPlanes(const core::Mat3& rotation_map_lidar, const ImageOptions& options, const RangeImage& image,
                const PlanesOut& out);

}  // namespace atlas::mapping
