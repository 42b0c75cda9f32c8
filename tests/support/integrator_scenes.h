// A furnished room and a LiDAR's walk through it, for tests of integrators.
#pragma once

#include <vector>

#include "mapping/integrator/integrator.h"
#include "tests/support/analytic_world.h"

namespace atlas::tests {

/// 8 x 6 x 3 m, with a box, a pillar, a thin pole and a ball in it, and a window in one wall.
inline AnalyticWorld FurnishedRoom() {
  AnalyticWorld world;
  world.AddPlane({0, 0, 1}, -0.013);
  world.AddPlane({0, 0, 1}, 2.987);
  world.AddPlane({1, 0, 0}, -4.021);
  world.AddPlane({0, 1, 0}, -3.017);
  world.AddPlane({0, 1, 0}, 3.023);
  world.AddBox({{4.011, -3.5, -0.5}, {4.2, -0.8, 3.5}});  // the wall with the window
  world.AddBox({{4.011, 0.7, -0.5}, {4.2, 3.5, 3.5}});
  world.AddBox({{1.52, 1.03, -0.02}, {2.51, 1.97, 0.83}});
  world.AddPillar(-2.0, 1.0, 0.2, -0.02, 3.0);
  world.AddPillar(1.0, -1.5, 0.02, -0.02, 2.0);
  world.AddSphere({-1.5, -1.5, 0.9}, 0.4);
  return world;
}

/// Few beams, so that closed forms are cast quickly.
inline core::LidarModel SmallLidar(int rows = 24, int columns = 300) {
  core::LidarModel lidar = core::FindLidarModel("os1_64");
  lidar.name = "small";
  lidar.elevation_rad.clear();
  lidar.azimuth_offset_rad.clear();
  for (int row = 0; row < rows; ++row) {
    lidar.elevation_rad.push_back(core::Radians(22.0 - 44.0 * row / (rows - 1)) +
                                  0.004 * std::sin(7.0 * row));
    lidar.azimuth_offset_rad.push_back(core::Radians(0.9) * (1.5 - row % 4));
  }
  lidar.columns = columns;
  return lidar;
}

/// Revolutions along a curved path at 0.8 m/s and up to 1 rad/s.
inline std::vector<core::SpinEvent> WalkThrough(const AnalyticWorld& world, const core::LidarModel& lidar,
                                                int spins, core::Rng* noise = nullptr) {
  core::PoseTrajectory path;
  for (int k = 0; k <= 20 * spins; ++k) {
    const double t = 0.01 * k;
    path.Add(t, core::MakePose(core::RotationFromYawPitchRoll(std::sin(1.1 * t), 0.05 * std::sin(5 * t),
                                                              0.08 * std::cos(4 * t)),
                               {-0.6 + 0.8 * t, 0.3 * std::sin(t), 1.2}));
  }
  std::vector<core::SpinEvent> events;
  for (int k = 0; k < spins; ++k) events.push_back(SpinThrough(world, lidar, 0.1 * k, path, noise));
  return events;
}

/// Every stored value with the kind of its block, by ascending code: equal exactly when maps are.
template <typename Field>
std::vector<uint8_t> DigestOf(const mapping::Octree<Field>& map) {
  std::vector<uint8_t> out;
  const auto append = [&out](const auto& thing) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(&thing);
    out.insert(out.end(), bytes, bytes + sizeof(thing));
  };
  auto leaf = std::make_unique<typename mapping::Octree<Field>::FineLeaf>();
  for (const auto* chunk : map.Chunks()) {
    append(chunk->key);
    for (int block = 0; block < mapping::kChunkBlocks; ++block) {
      append(chunk->Kind(block));
      if (chunk->Kind(block) == mapping::BlockKind::kUniform) {
        const auto value = chunk->uniform.Get(block);
        if constexpr (std::is_same_v<Field, mapping::TsdfField>) {  // its padding holds anything
          append(value.distance);
          append(value.weight);
        } else {
          append(value);
        }
      } else {
        map.Expand(*chunk, block, leaf.get());
        append(*leaf);
      }
    }
  }
  return out;
}

template <typename Field>
mapping::Octree<Field> MapOf(const std::vector<core::SpinEvent>& spins, const core::LidarModel& lidar,
                             const mapping::IntegratorParams& params, double resolution_m) {
  mapping::Octree<Field> map(resolution_m);
  const auto integrator = mapping::MakeConeIntegrator<Field>(params, lidar);
  for (const core::SpinEvent& spin : spins) integrator->Integrate(spin, core::Pose::Identity(), &map);
  return map;
}

}  // namespace atlas::tests
