// The builders that catalog.inc names, one .cc each.
#pragma once

#include "robots/robot_spec.h"

namespace atlas::robots {

#define ATLAS_ROBOT(name, builder, doc) RobotSpec builder();
#include "robots/catalog.inc"
#undef ATLAS_ROBOT

}  // namespace atlas::robots
