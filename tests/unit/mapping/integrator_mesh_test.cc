// Meshes of shapes that a LiDAR scanned from several poses, through the integrator.

#include <gtest/gtest.h>

#include "mapping/integrator/integrator.h"
#include "mapping/meshing/marching_cubes.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/mesh_cracks.h"
#include "tests/support/shape_scans.h"

namespace atlas {
namespace {

using core::Vec3;
using mapping::OccupancyField;
using mapping::TsdfField;

struct Shot {
  const tests::AnalyticShape& shape;
  std::vector<core::Pose> poses;
  core::Box3 region;  ///< what is mapped and judged
};

template <typename Field>
void ExpectAccurate(const Shot& shot, double resolution_m) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  mapping::IntegratorParams params;
  params.region_map = shot.region;
  const auto integrator = mapping::MakeConeIntegrator<Field>(params, lidar);
  mapping::Octree<Field> map(resolution_m);
  core::Rng rng(5);
  constexpr double kNoise_m = 0.015;
  for (const core::Pose& T : shot.poses) {
    integrator->Integrate(tests::ScanShape(shot.shape, lidar, T, kNoise_m, &rng), core::Pose::Identity(),
                          &map);
  }
  const core::TriMesh mesh = ExtractMesh(map, {});
  ASSERT_GT(mesh.triangles.size(), 1000u);
  const tests::MeshError error = tests::ErrorOf(mesh, shot.shape);
  EXPECT_LT(error.mean_m, 0.2 * resolution_m) << Field::kName << " at " << resolution_m;
  const tests::MeshFaults faults = tests::FindFaults(ExtractMesh(map, {.undo_shift = false}), map);
  EXPECT_TRUE(faults.None()) << faults.cracks << " cracks, " << faults.crowded << " crowded";
}

TEST(MeshOfIntegratedScans, SphereErrsByLessThanAFifthOfAVoxel) {
  const tests::Sphere sphere(Vec3(0.31, -0.17, 0.42), 1.25);
  core::Rng rng(1);
  const Shot shot{sphere,
                  tests::RingOfPoses(Vec3(0.3, -0.2, 0.4), 4.5, -1.5, 2.0, 9, &rng),
                  {Vec3(-1.5, -2.0, -1.5), Vec3(2.2, 1.7, 2.3)}};
  ExpectAccurate<OccupancyField>(shot, 0.065);
  ExpectAccurate<TsdfField>(shot, 0.065);
  ExpectAccurate<TsdfField>(shot, 0.10);
}

TEST(MeshOfIntegratedScans, BoxOfDistancesErrsByLessThanAFifthOfAVoxel) {
  const tests::SolidBox box(Vec3(0.1, 0.2, 0.3), Vec3(1.2, 0.8, 0.9),
                            core::RotationFromYawPitchRoll(0.5, 0.0, 0.0));
  core::Rng rng(2);
  const Shot shot{box,
                  tests::RingOfPoses(Vec3(0.1, 0.2, 0.3), 4.5, -0.5, 2.2, 9, &rng),
                  {Vec3(-2.2, -2.0, -1.2), Vec3(2.2, 2.2, 1.8)}};
  ExpectAccurate<TsdfField>(shot, 0.065);
  ExpectAccurate<TsdfField>(shot, 0.10);
}

TEST(MeshOfIntegratedScans, GroundOfDistancesErrsByLessThanAFifthOfAVoxel) {
  const tests::HalfSpace ground(Vec3(0, 0, 0.023), Vec3(0.0, 0.0, 1.0));
  core::Rng rng(3);
  const Shot shot{ground,
                  tests::RingOfPoses(Vec3::Zero(), 2.5, 0.8, 1.8, 9, &rng),
                  {Vec3(-5.0, -5.0, -1.0), Vec3(5.0, 5.0, 1.0)}};
  ExpectAccurate<TsdfField>(shot, 0.065);
  ExpectAccurate<TsdfField>(shot, 0.10);
}

}  // namespace
}  // namespace atlas
