// Stage 2, measurement: how near to what a beam met space is free.
#pragma once

#include <array>
#include <vector>

#include "mapping/integrator/measurement/surface_image.h"

namespace atlas::mapping {

/// For each cell the range up to which space is free for voxels of a scale, 3 sigma and the voxel's support
/// off the plane, with kPad columns left to be repeated on the right; scale index 0, 1, 2 is 1, 2, 4 voxels.
struct Margins {
  const RangeImage* image;  ///< of these ranges
  static constexpr int kPad = GridColumns::kWindowReach;
  int pitch = 0;                               ///< columns + kPad
  std::array<std::vector<float>, 3> own;       ///< for the cell's own beam; rows * pitch
  std::array<std::vector<float>, 3> surround;  ///< for the beams around it; a row below `own`

  explicit Margins(const RangeImage& of) : image(&of), pitch(of.columns + kPad) {}
};

/// What one pass over the returns fills.
struct PlanesOut {
  SurfaceImage* surface;
  Margins* margins;
};
/// @param rotation_map_lidar  for the voxel's support along normals.
void FindPlanes(const core::Mat3& rotation_map_lidar, const ImageOptions& options, const RangeImage& image,
                const PlanesOut& out);

}  // namespace atlas::mapping
