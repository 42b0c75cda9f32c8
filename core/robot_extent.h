// How much room a robot takes.
#pragma once

namespace atlas::core {

struct RobotExtent {
  double stance_height_m = 0.44;     ///< base origin above the soles
  double footprint_radius_m = 0.55;  ///< circle about the base that holds the body and legs while turning
  double half_length_m = 0.55;
  double half_width_m = 0.33;
  double body_top_m = 0.35;  ///< highest point above the base origin (LiDAR included): overhang clearance
};

}  // namespace atlas::core
