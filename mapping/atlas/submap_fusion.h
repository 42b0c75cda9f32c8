// The evidence of one submap goes into another (thesis 4.8.1, Eq. 4.6).
#pragma once

#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

/// Evidence of two submaps on one voxel: log-odds add up, clamped; where a surface lies in the voxel is the
/// mean of what both say, by their evidence.
int8_t FusedValue(int8_t a, int8_t b);

enum class FusionRule {
  kAdd,    ///< FusedValue
  kFirst,  ///< what is known stays
};

/// Adds what `from` holds to `to`. The thesis sends voxels of `from` to where they fall in `to`, which leaves
/// holes where lattices are turned to each other; here each voxel of `to` asks `from` what lies at its
/// centre. Where in a voxel a surface lies is told anew for the voxel that now holds it, along the gradient
/// of log-odds, so that resampling does not roughen surfaces. Cells stay as coarse as the finer of both
/// submaps has them there; blocks that are free throughout keep the least free value. Where both hold signed
/// distances these are fused (FuseDistances), and tell the states anew. Summaries are current
/// afterwards. The same bytes on any machine and number of threads.
/// @pre both of one resolution and field (kFirst: `to` may lack distances); summaries of `from` current
void FuseInto(const OctreeContents& from, const core::Pose& T_to_from, FusionRule rule, OctreeContents* to);

}  // namespace atlas::mapping
