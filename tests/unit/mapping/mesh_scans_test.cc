// Meshes of shapes that a LiDAR scanned from several poses, through a brute-force projective oracle.

#include <gtest/gtest.h>

#include "tests/support/mesh_of_scans.h"
#include "tests/support/projective_oracle.h"

namespace atlas {
namespace {

template <typename Field>
void ExpectAccurate(const tests::Shot& shot, double resolution_m) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  tests::ExpectAccurateMesh<Field>(shot, lidar, resolution_m, [&](const core::SpinEvent& spin, auto* map) {
    tests::IntegratePlainly(spin, lidar, shot.shape, shot.region, {}, map);
  });
}

void ExpectAccurateInAllFields(const tests::Shot& shot) {
  for (const double resolution_m : {0.065, 0.10}) {
    ExpectAccurate<mapping::OccupancyField>(shot, resolution_m);
    ExpectAccurate<mapping::TsdfField>(shot, resolution_m);
  }
}

TEST(MeshOfScans, SphereErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurateInAllFields(tests::ShotOfSphere());
}

TEST(MeshOfScans, BoxErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurateInAllFields(tests::ShotOfBox());
}

TEST(MeshOfScans, GroundErrsByLessThanAFifthOfAVoxel) {
  ExpectAccurateInAllFields(tests::ShotOfGround(3.0));
}

}  // namespace
}  // namespace atlas
