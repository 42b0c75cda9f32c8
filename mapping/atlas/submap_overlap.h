// How much of what two submaps measured is the same: Submap Overlap Estimate (thesis 4.8.2, Algorithm 2).
#pragma once

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Voxels of the smallest size that are known, whatever they are stored in: a free block of eight a side
/// counts 512.
uint64_t KnownVoxels(const OccupancyOctree& tree);

/// Shares of the known volume of either that the other knows, and knows as the same: both free or both
/// occupied.
struct SubmapOverlap {
  double of_read = 0.0, of_ref = 0.0;
};

/// Each cell of `read` is looked up in `ref` where its centre lies; of a uniform block the centres of its
/// octants, each for 64 voxels.
/// @param known_read  KnownVoxels of either
SubmapOverlap OverlapOf(const OccupancyOctree& read, uint64_t known_read, const OccupancyOctree& ref,
                        uint64_t known_ref, const core::Pose& T_ref_read);

/// The same of boxes: shares of either's volume. Zero where one is empty.
SubmapOverlap OverlapOf(const core::Box3& read, const core::Box3& ref);

}  // namespace atlas::mapping
