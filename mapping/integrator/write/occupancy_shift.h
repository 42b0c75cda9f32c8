// How far an occupancy surface stands in front of the true one.
//
// An occupancy voxel is occupied where the surface passes through any part of it, so Eq. 4.2 is evaluated
// against the surface moved towards the sensor by the voxel's support along the surface's normal: evidence is
// zero where a corner touches the surface. Meshes of occupancy maps undo it by moving each vertex inwards
// (against the normal that points to free space) by the same length.
#pragma once

#include <cmath>

#include "core/geometry.h"

namespace atlas::mapping {

/// Half the extent of a voxel of side `resolution_m` along unit `normal`: resolution / 2 (|nx| + |ny| +
/// |nz|), between 0.5 and 0.87 resolutions.
inline double OccupancyShift(const core::Vec3& normal, double resolution_m) {
  return 0.5 * resolution_m * normal.lpNorm<1>();
}

}  // namespace atlas::mapping
