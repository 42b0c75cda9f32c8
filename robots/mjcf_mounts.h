// What can be read from a robot's MJCF without compiling it.
#pragma once

#include "robots/robot_spec.h"

namespace atlas::robots {

/// Fills T_base_lidar and T_base_depth from the sites `lidar` and `depth` of the body `base` (pos, quat), and
/// checks that the twelve leg joints and four foot sites are there.
/// @throws InputError for a missing file, malformed XML (with its line), or a name that is missing.
void ReadMounts(RobotSpec* spec);

}  // namespace atlas::robots
