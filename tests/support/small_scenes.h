// Scenes of a few triangles, for tests that need a world but no object.
#pragma once

#include <string>

#include "scenes/scene_spec.h"

namespace atlas::tests {

/// A labelled box: its mesh for rays and its shape for physics.
inline scenes::ScenePart BoxPart(const std::string& name, const core::Vec3& half, const core::Vec3& center) {
  scenes::ScenePart part;
  part.name = name;
  part.label = core::Label::kGround;
  for (int i = 0; i < 8; ++i) {
    const core::Vec3 corner((i & 1) ? half.x() : -half.x(), (i & 2) ? half.y() : -half.y(),
                            (i & 4) ? half.z() : -half.z());
    part.mesh.vertices.push_back((center + corner).cast<float>());
  }
  part.mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  part.collision.push_back({scenes::BoxShape{half}, core::PoseFromXyzYaw(center, 0.0)});
  return part;
}

/// A floor of 80 m x 80 m whose top is z = 0; the robot stands at its middle and looks along x.
inline scenes::SceneSpec OpenFloor() {
  scenes::SceneSpec scene;
  scene.name = "open_floor";
  scene.parts.push_back(BoxPart("floor", {40.0, 40.0, 0.25}, {0.0, 0.0, -0.25}));
  return scene;
}

}  // namespace atlas::tests
