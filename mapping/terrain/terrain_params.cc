#include "mapping/terrain/elevation_map.h"

namespace atlas::mapping {

void TerrainParams::Visit(core::ParamVisitor& v) {
  v.Field("cell_m", &cell_m, {.unit = "m", .min = 0.02, .max = 0.2, .doc = "edge of an elevation cell"});
  v.Field("window_m", &window_m,
          {.unit = "m",
           .min = 3.0,
           .max = 30.0,
           .doc = "side of the square about the robot that the elevation map holds; as much as "
                  "planner.window_m, unless told"});
  v.Field(
      "max_fill_m", &max_fill_m,
      {.unit = "m", .min = 0.0, .max = 0.6, .doc = "gaps up to this wide are interpolated, wider ones stay"});
  v.Field("critical_step_m", &critical_step_m,
          {.unit = "m", .min = 0.02, .max = 0.4, .doc = "higher steps are not traversable"});
  v.Field("critical_slope_deg", &critical_slope_deg,
          {.unit = "deg", .min = 2.0, .max = 45.0, .doc = "steeper ground is not traversable"});
  v.Field(
      "critical_roughness_m", &critical_roughness_m,
      {.unit = "m", .min = 0.01, .max = 0.3, .doc = "rms deviation from the plane under the robot, at most"});
  v.Field("negative_obstacle_m", &negative_obstacle_m,
          {.unit = "m", .min = 0.1, .max = 1.0, .doc = "a drop deeper than this is an edge"});
  v.Field("edge_clearance_m", &edge_clearance_m,
          {.unit = "m",
           .min = 0.0,
           .max = 0.5,
           .doc = "from the footprint's rim to an edge, a hole or the unknown"});
  v.Field("min_traversability", &min_traversability,
          {.min = 0.0, .max = 1.0, .doc = "cells below this block the footprint"});
  v.Field("initial_ground_radius_m", &initial_ground_radius_m,
          {.unit = "m", .min = 0.0, .max = 3.0, .doc = "ground assumed solid around the robot at the start"});
}

}  // namespace atlas::mapping
