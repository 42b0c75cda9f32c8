// One MuJoCo model from a scene and a robot.
#pragma once

#include <string>

#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"

namespace atlas::sim {

/// MJCF that includes the robot's file and holds every collision shape of the scene. The shapes stand on
/// static bodies, one a tile of a few metres, because broad-phase culling works per body and never culls the
/// world body. Height grids come out flat: `StaticShapeName` finds them for filling after the load.
std::string ComposeMjcf(const scenes::SceneSpec& scene, const robots::RobotSpec& robot);

/// Name of the geom (and of its mesh or height field) of shape `shape` of part `part`.
std::string StaticShapeName(size_t part, size_t shape);

}  // namespace atlas::sim
