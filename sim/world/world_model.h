// The compiled MuJoCo model of a scene and a robot.
#pragma once

#include <memory>

#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"

struct mjModel_;

namespace atlas::sim {

struct ModelDeleter {
  void operator()(mjModel_* model) const;
};
using ModelPtr = std::unique_ptr<mjModel_, ModelDeleter>;

/// Compiles ComposeMjcf(scene, robot) and fills its height fields. @throws InputError with the compiler's
/// reason.
ModelPtr CompileModel(const scenes::SceneSpec& scene, const robots::RobotSpec& robot);

}  // namespace atlas::sim
