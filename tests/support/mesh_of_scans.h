// Shapes that a LiDAR scans with noise from a ring of poses, and what a mesh of its map must hold to.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mapping/meshing/marching_cubes.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/mesh_cracks.h"
#include "tests/support/shape_scans.h"

namespace atlas::tests {

struct Shot {
  const AnalyticShape& shape;
  std::vector<core::Pose> poses;
  core::Box3 region;  ///< what is mapped and judged
};

inline const Sphere kScannedSphere(core::Vec3(0.31, -0.17, 0.42), 1.25);
inline const SolidBox kScannedBox(core::Vec3(0.1, 0.2, 0.3), core::Vec3(1.2, 0.8, 0.9),
                                  core::RotationFromYawPitchRoll(0.5, 0.0, 0.0));
inline const HalfSpace kScannedGround(core::Vec3(0, 0, 0.023), core::Vec3(0.0, 0.0, 1.0));

inline Shot ShotOfSphere() {
  core::Rng rng(1);
  return {kScannedSphere,
          RingOfPoses(core::Vec3(0.3, -0.2, 0.4), 4.5, -1.5, 2.0, 9, &rng),
          {core::Vec3(-1.5, -2.0, -1.5), core::Vec3(2.2, 1.7, 2.3)}};
}
inline Shot ShotOfBox() {
  core::Rng rng(2);
  return {kScannedBox,
          RingOfPoses(core::Vec3(0.1, 0.2, 0.3), 4.5, -0.5, 2.2, 9, &rng),
          {core::Vec3(-2.2, -2.0, -1.2), core::Vec3(2.2, 2.2, 1.8)}};
}
/// @param reach_m  half the side of what is mapped.
inline Shot ShotOfGround(double reach_m) {
  core::Rng rng(3);
  return {kScannedGround,
          RingOfPoses(core::Vec3::Zero(), 2.5, 0.8, 1.8, 9, &rng),
          {core::Vec3(-reach_m, -reach_m, -1.0), core::Vec3(reach_m, reach_m, 1.0)}};
}

/// The mesh of all scans errs by less than a fifth of a voxel on average and has no cracks.
/// @param integrate  takes a scan and the map.
template <typename Field, typename Integrate>
void ExpectAccurateMesh(const Shot& shot, const core::LidarModel& lidar, double resolution_m,
                        const Integrate& integrate) {
  mapping::Octree<Field> map(resolution_m);
  core::Rng rng(5);
  constexpr double kNoise_m = 0.015;
  for (const core::Pose& T : shot.poses) integrate(ScanShape(shot.shape, lidar, T, kNoise_m, &rng), &map);
  const core::TriMesh mesh = ExtractMesh(map, {});
  ASSERT_GT(mesh.triangles.size(), 1000u);
  const MeshError error = ErrorOf(mesh, shot.shape);
  EXPECT_LT(error.mean_m, 0.2 * resolution_m) << Field::kName << " at " << resolution_m;
  ::testing::Test::RecordProperty(
      std::string(Field::kName) + "_" + std::to_string(std::lround(1e3 * resolution_m)) + "mm_mean_voxels",
      std::to_string(error.mean_m / resolution_m));
  const MeshFaults faults = FindFaults(ExtractMesh(map, {.undo_shift = false}), map);
  EXPECT_TRUE(faults.None()) << faults.cracks << " cracks, " << faults.crowded << " crowded";
}

}  // namespace atlas::tests
