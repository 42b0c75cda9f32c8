// A submap (thesis 4.3.2): a rigid map of its own, in the frame of the keyframe that it began with.
#pragma once

#include <cstdint>
#include <vector>

#include "core/keyframe.h"
#include "mapping/atlas/overlap_cloud.h"
#include "mapping/copy_on_write.h"
#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

struct Submap {
  Submap(uint32_t number, core::KeyframeId root_keyframe, OctreeContents empty, double filter_m)
      : id(number), root(root_keyframe), contents(std::move(empty)), cloud(filter_m) {}

  uint32_t id;                                       ///< counted from 0; never given again
  core::KeyframeId root;                             ///< the submap's frame is this keyframe's
  core::Pose T_map_submap = core::Pose::Identity();  ///< as of the latest poses
  std::vector<core::KeyframeId> keyframes;           ///< whose revolutions it holds, ascending
  CopyOnWrite<OctreeContents> contents;
  core::Box3 bounds_submap;  ///< of all that it can know: whole chunks
  OverlapCloud cloud;        ///< accumulated, submap frame
  double overlap = 0.0;      ///< of its root's cloud with the submap in use before (thesis Alg. 1)
  uint64_t latest = 0;       ///< the atlas's count of revolutions when this submap last took one
};

/// The box of a tree's chunks, in its own frame; empty where it has none.
core::Box3 BoundsOf(const OccupancyOctree& tree);
/// The smallest axis-aligned box around a box that was moved by T. Empty stays empty.
core::Box3 BoxAround(const core::Box3& box, const core::Pose& T);

}  // namespace atlas::mapping
