// An OctoMap tree as planners see a map.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/grid/dense_grid.h"
#include "mapping/grid/occupied_index.h"

namespace octomap {
class OcTree;
class OcTreeKey;
}  // namespace octomap

namespace atlas::mapping {

/// Reads the tree itself: states, probabilities along rays, occupied voxels. What the tree cannot hold is
/// kept beside it: how far behind a surface an unmeasured voxel lies, and an index of the occupied voxels.
class OctomapView : public OccupancyView {
 public:
  /// `tree` outlives this; all outside `frame` is unknown, whatever the tree holds there.
  OctomapView(const octomap::OcTree& tree, const GridFrame& frame);

  const GridFrame& frame() const { return frame_; }
  /// Whether the voxel lies in the region.
  bool Holds(const octomap::OcTreeKey& key) const;
  /// The greatest value stays; it counts while the voxel is unmeasured.
  void SetBehindSurface(size_t index, int value);
  /// Brings the index up to the tree. Call after a batch of changes, before OccupiedCenters and
  /// DistanceToOccupied.
  void FinishUpdate();
  /// Of what is kept beside the tree for rays.
  size_t Bytes() const { return behind_.size(); }

  double resolution_m() const override { return frame_.resolution_m(); }
  const core::Box3& region() const override { return frame_.box(); }
  CellState StateAt(const core::Vec3& p_map) const override;
  RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, double max_range_m,
               std::vector<RaySample>* samples) const override;
  std::vector<core::Vec3f> OccupiedCenters() const override { return occupied_.centers(); }
  double DistanceToOccupied(const core::Vec3& p_map, double limit_m) const override {
    return occupied_.DistanceTo(p_map, limit_m);
  }

 private:
  const octomap::OcTree& tree_;
  GridFrame frame_;
  uint16_t first_key_[3];  ///< of voxel (0, 0, 0)
  std::vector<uint8_t> behind_;
  OccupiedIndex occupied_;
};

}  // namespace atlas::mapping
