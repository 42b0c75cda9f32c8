// Meshes of shapes that a LiDAR scanned from several poses, through the integrator.

#include <gtest/gtest.h>

#include "mapping/integrator/integrator.h"
#include "tests/support/mesh_of_scans.h"

namespace atlas {
namespace {

using mapping::OccupancyField;
using mapping::TsdfField;

template <typename Field>
void ExpectAccurate(const tests::Shot& shot, double resolution_m) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  mapping::IntegratorParams params;
  params.region_map = shot.region;
  const auto integrator = mapping::MakeConeIntegrator<Field>(params, lidar);
  tests::ExpectAccurateMesh<Field>(shot, lidar, resolution_m, [&](const core::SpinEvent& spin, auto* map) {
    integrator->Integrate(spin, core::Pose::Identity(), map);
  });
}

TEST(MeshOfIntegratedScans, SphereErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurate<OccupancyField>(tests::ShotOfSphere(), 0.065);
  ExpectAccurate<OccupancyField>(tests::ShotOfSphere(), 0.10);
  ExpectAccurate<TsdfField>(tests::ShotOfSphere(), 0.065);
  ExpectAccurate<TsdfField>(tests::ShotOfSphere(), 0.10);
}

TEST(MeshOfIntegratedScans, BoxErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurate<OccupancyField>(tests::ShotOfBox(), 0.065);
  ExpectAccurate<OccupancyField>(tests::ShotOfBox(), 0.10);
  ExpectAccurate<TsdfField>(tests::ShotOfBox(), 0.065);
  ExpectAccurate<TsdfField>(tests::ShotOfBox(), 0.10);
}

TEST(MeshOfIntegratedScans, GroundErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurate<OccupancyField>(tests::ShotOfGround(5.0), 0.065);
  ExpectAccurate<OccupancyField>(tests::ShotOfGround(5.0), 0.10);
  ExpectAccurate<TsdfField>(tests::ShotOfGround(5.0), 0.065);
  ExpectAccurate<TsdfField>(tests::ShotOfGround(5.0), 0.10);
}

}  // namespace
}  // namespace atlas
