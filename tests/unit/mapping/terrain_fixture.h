// What the terrain tests share: the stance, a flat world, a map after sweeps.
#pragma once

#include <memory>
#include <vector>

#include "mapping/terrain/elevation_map.h"
#include "tests/support/terrain_scenes.h"

namespace atlas::mapping {

constexpr double kStance = 0.44;

inline tests::PatchWorld FlatWorld() {
  tests::PatchWorld world;
  world.AddRectangle(-20, -20, 20, 20, 0);
  return world;
}

/// On ground of this height.
inline core::Vec3 Place(const core::Vec2& p, double height_m = 0.0) {
  return {p.x(), p.y(), height_m};
}

struct Survey {
  uint64_t seed = 1;
  double yaw_rad = 0.0;
  int depth_images = 3;  ///< after each sweep
  bool update_each = true;
  double window_m = TerrainParams{}.window_m;
};

/// A map after sweeps from these points on the ground of a world.
inline std::unique_ptr<ElevationMap> MapAfterSweeps(const tests::PatchWorld& world,
                                                    const std::vector<core::Vec3>& stands,
                                                    const Survey& survey) {
  TerrainParams params;
  params.window_m = survey.window_m;
  auto map = std::make_unique<ElevationMap>(params, core::RobotExtent{});
  tests::TerrainSensors sensors(&world, survey.seed);
  const core::Vec3 up(0, 0, kStance);
  map->InitialiseUnderRobot(core::PoseFromXyzYaw(stands.front() + up, 0));
  for (const core::Vec3& stand : stands) {
    const core::Pose T = core::PoseFromXyzYaw(stand + up, survey.yaw_rad);
    sensors.Sweep(T, core::Radians(40), 50, map.get());
    for (int k = 0; k < survey.depth_images; ++k) {
      map->OnDepth(sensors.Depth(T, 0.4, core::Radians(25), 0));
    }
    if (survey.update_each) map->Update();
  }
  map->Update();
  return map;
}

}  // namespace atlas::mapping
