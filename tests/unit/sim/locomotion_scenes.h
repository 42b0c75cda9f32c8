// Small worlds for tests of the walking robot.
#pragma once

#include <cmath>

#include "core/rng.h"
#include "core/terrain_view.h"
#include "scenes/scene_spec.h"

namespace atlas::sim::test {

/// A labelled box: its mesh for rays and its shape for physics.
inline scenes::ScenePart BoxPart(const std::string& name, const core::Vec3& half,
                                 const core::Pose& T_map_box) {
  scenes::ScenePart part;
  part.name = name;
  part.label = core::Label::kGround;
  for (int i = 0; i < 8; ++i) {
    const core::Vec3 corner((i & 1) ? half.x() : -half.x(), (i & 2) ? half.y() : -half.y(),
                            (i & 4) ? half.z() : -half.z());
    part.mesh.vertices.push_back((T_map_box * corner).cast<float>());
  }
  part.mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  part.collision.push_back({scenes::BoxShape{half}, T_map_box});
  return part;
}

inline core::Pose At(double x, double y, double z) {
  return core::PoseFromXyzYaw({x, y, z}, 0.0);
}

/// A floor of 80 m x 80 m whose top is z = 0, and the robot at its middle looking along x.
inline scenes::SceneSpec FlatScene() {
  scenes::SceneSpec scene;
  scene.name = "flat";
  scene.parts.push_back(BoxPart("floor", {40.0, 40.0, 0.25}, At(0.0, 0.0, -0.25)));
  return scene;
}

/// The floor and a kerb of height `step_m` from x = 1.2 to 3.2.
inline scenes::SceneSpec KerbScene(double step_m) {
  scenes::SceneSpec scene = FlatScene();
  scene.parts.push_back(BoxPart("kerb", {1.0, 3.0, 0.5 * step_m}, At(2.2, 0.0, 0.5 * step_m)));
  return scene;
}

/// A ramp of 3 m from x = 1.2, a plateau of 2 m and a ramp down.
inline scenes::SceneSpec RampScene(double slope_rad) {
  constexpr double kHalfThickness = 0.2, kHalfLength = 1.5;
  const double run = 2.0 * kHalfLength * std::cos(slope_rad), rise = 2.0 * kHalfLength * std::sin(slope_rad);
  scenes::SceneSpec scene = FlatScene();
  const auto slab = [&](const std::string& name, double x_mid, double sign) {
    const core::Mat3 R = core::RotationFromYawPitchRoll(0.0, -sign * slope_rad, 0.0);
    const core::Vec3 top(x_mid, 0.0, 0.5 * rise);
    const core::Vec3 middle = top - R * core::Vec3(0.0, 0.0, kHalfThickness);
    scene.parts.push_back(BoxPart(name, {kHalfLength, 3.0, kHalfThickness}, core::MakePose(R, middle)));
  };
  slab("up", 1.2 + 0.5 * run, 1.0);
  scene.parts.push_back(BoxPart("plateau", {1.0, 3.0, 0.5 * rise}, At(1.2 + run + 1.0, 0.0, 0.5 * rise)));
  slab("down", 1.2 + 1.5 * run + 2.0, -1.0);
  return scene;
}

/// A map of true heights seen through 4 cm cells and 1 cm of noise; cells beside a step above 3 cm cannot be
/// stepped on.
template <typename HeightAt>
class PerceivedTerrain : public core::TerrainView {
 public:
  PerceivedTerrain(HeightAt height_at, double sigma_m, uint64_t seed)
      : height_at_(std::move(height_at)), sigma_m_(sigma_m), seed_(seed) {}

  Ground At(double x_map, double y_map) const override {
    const double x = (std::floor(x_map / kCellM) + 0.5) * kCellM,
                 y = (std::floor(y_map / kCellM) + 0.5) * kCellM;
    const double z = height_at_(x, y);
    const auto index = static_cast<uint64_t>(std::lround(x / kCellM * 2.0) + 100000) * 200001u +
                       static_cast<uint64_t>(std::lround(y / kCellM * 2.0) + 100000);
    Ground ground{z + sigma_m_ * core::NormalAt(seed_, index), true, true};
    for (const double dx : {-kCellM, 0.0, kCellM}) {
      for (const double dy : {-kCellM, 0.0, kCellM}) {
        if (std::abs(height_at_(x + dx, y + dy) - z) > 0.03) ground.steppable = false;
      }
    }
    return ground;
  }

 private:
  static constexpr double kCellM = 0.04;
  HeightAt height_at_;
  double sigma_m_;
  uint64_t seed_;
};

}  // namespace atlas::sim::test
