// A map from above: its occupied voxels in a slice above each floor, submaps a colour each, the graph with
// its loops, and a planned way where there is one.
#pragma once

#include <utility>
#include <vector>

#include "core/geometry.h"
#include "core/keyframe.h"
#include "mapping/map_view.h"
#include "sim/render/colored_mesh.h"

namespace atlas::experiments {

struct AtlasDrawing {
  const mapping::MapView* map = nullptr;
  core::Box3 box_map;             ///< what is drawn
  std::vector<core::Vec3> nodes;  ///< keyframes where they lie now, in their order
  std::vector<uint32_t> submap;   ///< of each node
  std::vector<std::pair<core::KeyframeId, core::KeyframeId>> loops;
  std::vector<core::Vec3> way;  ///< planned; empty: none
};

/// A panel a floor (nodes less than 2 m apart in height), side by side, x to the right, y up.
sim::RgbImage AtlasPicture(const AtlasDrawing& drawing);

}  // namespace atlas::experiments
