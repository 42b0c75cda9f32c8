// What planners and collision checks ask of an octree, at the coarsest level that answers.
#pragma once

#include <functional>
#include <span>

#include "mapping/occupancy_view.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// A stretch of a ray inside one stored cell (a whole free or unknown node, a coarse cell, a voxel).
template <typename Field>
struct RaySegment {
  typename Field::Value value;
  double t_begin_m = 0.0, t_end_m = 0.0;
  int level = 0;  ///< of the cell: 0 voxel, 1 coarse cell, 3 block ... 6 chunk
};

/// Walks a ray to `max_range_m`, whole nodes at a time, nearest first, until `visit` returns false.
/// @pre direction is unit.
template <typename Field>
void TraceRay(const Octree<Field>& map, const core::Vec3& origin, const core::Vec3& direction,
              double max_range_m, const std::function<bool(const RaySegment<Field>&)>& visit);

/// Distance to the first occupied cell, or nothing within the range; unknown space is passed.
template <typename Field>
std::optional<double> FirstOccupied(const Octree<Field>& map, const core::Vec3& origin,
                                    const core::Vec3& direction, double max_range_m);

/// Occupied if any voxel that overlaps `box` is; else unknown if any is; else free.
template <typename Field>
CellState StateOfBox(const Octree<Field>& map, const core::Box3& box);

/// The same of a sphere moved along a polyline (a swept volume). Conservative by less than a voxel.
template <typename Field>
CellState StateOfSweptSphere(const Octree<Field>& map, std::span<const core::Vec3> path, double radius_m);

/// Calls `visit(key, level, value)` on every stored cell with a known value, by Morton order of chunks and
/// blocks; key counts cells of side 2^level.
template <typename Field>
void ForEachCell(
    const Octree<Field>& map,
    const std::function<void(const NodeKey& key, int level, typename Field::Value value)>& visit);

}  // namespace atlas::mapping
