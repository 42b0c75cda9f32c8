// The directions in which a node looks: a stratified grid over the solid angle of the object box.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "planner/gain/sweep_view.h"

namespace atlas::planner {

struct RayDirection {
  core::Vec3 direction_map;  ///< unit
  double azimuth_rad = 0.0;  ///< from the map's x axis
  double elevation_rad = 0.0;
  double solid_angle_sr = 0.0;  ///< that this direction stands for
};

/// Directions from `origin_map` into `object_box` within `max_range_m` that some heading of a sweep sees.
///
/// At least `rays` of them lie in the elevations that every heading sees, so each candidate of the node has
/// as many, whatever its heading; elevations that only some headings see are sampled half as densely. Where
/// the box lies wholly outside the common elevations, at least `rays` lie in the rest. Each direction is
/// jittered inside its cell by a hash of the cell, so results repeat. Empty when no part of the box is in
/// reach.
std::vector<RayDirection> DirectionsInto(const core::Box3& object_box, const core::Vec3& origin_map,
                                         const SweepView& view, int rays, double max_range_m);

}  // namespace atlas::planner
