// Signed distances of one submap go into another (thesis 4.8.1, Eq. 4.6).
#pragma once

#include <cstdint>
#include <map>

#include "core/geometry.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// The mean of two distances by their weights, and both weights together; what only one knows stays.
TsdfField::Value FusedDistance(TsdfField::Value a, TsdfField::Value b);

/// Adds what `from` holds to those blocks of `to`, by the codes of their chunks. Each voxel of `to` asks
/// `from` what the distance is at its middle: between the eight voxels around it where all are known (a
/// distance changes by less than a voxel from one to the next), else of the voxel that it lies in. Cells stay
/// as coarse as the finer of both has them there. Summaries are current afterwards, empty chunks gone. The
/// same bytes on any machine.
/// @pre both of one resolution
void FuseDistances(const TsdfOctree& from, const core::Pose& T_to_from,
                   const std::map<uint64_t, BlockMask>& blocks, TsdfOctree* to);

}  // namespace atlas::mapping
