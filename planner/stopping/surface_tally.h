// How much of the object's surface was seen, counted so that it only grows.
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry.h"
#include "mapping/terrain/traversable_ground.h"

namespace atlas::planner {

/// Voxels of the object's box that returns fell into, the ground left out. Unlike the map's occupied voxels,
/// which also lie behind surfaces, and vanish as grazing rays clear them, this follows the coverage of the
/// object without knowing the truth, whatever the map. A voxel beside one that earlier calls saw shows the
/// same surface to within the map's resolution (noise thickens what is seen again and again) and does not
/// count.
class SurfaceTally {
 public:
  /// @pre voxel_m > 0, the map's resolution.
  SurfaceTally(const core::Box3& object_box, double voxel_m);

  /// Of the voxels that these returns fell into, how many lie on the object, and neither they nor any of
  /// their 26 neighbours held one in an earlier call. Returns lower than two voxels above the ground under
  /// them are ground; of floors above one another that is the highest of which they lie no more than two
  /// voxels below.
  size_t CountNew(const std::vector<core::Vec3f>& returns_map, const mapping::TraversableGround& ground);

 private:
  size_t IndexOf(const int cell[3]) const;
  bool SeenAround(size_t index) const;

  core::Box3 box_;
  double voxel_m_;
  int size_[3];
  std::vector<bool> seen_;
};

}  // namespace atlas::planner
