// An OctoMap tree as planners see a map.
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <optional>

#include "mapping/map_view.h"
#include "mapping/octree/behind_surface.h"

namespace atlas::mapping {

/// The library counts voxels from here, so that keys are positive.
inline constexpr int kOctomapZero = 32768;

/// What a map holds: the library's tree, and beside it what that cannot hold.
struct OctomapContents {
  octomap::OcTree tree;
  std::optional<BehindSurface> behind = {};

  OctomapContents Clone() const { return {tree, behind}; }
};

/// Reads the tree itself. What its leaves hold for a cube of voxels is crossed in one step.
class OctomapView final : public MapView {
 public:
  explicit OctomapView(std::shared_ptr<const OctomapContents> contents) : contents_(std::move(contents)) {}

  double resolution_m() const override { return contents_->tree.getResolution(); }
  CellState StateAt(const core::Vec3& p_map) const override;
  RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, const TraceLimits& limits,
               std::vector<RaySample>* samples) const override;
  void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const override;

 private:
  std::shared_ptr<const OctomapContents> contents_;
};

}  // namespace atlas::mapping
