#include <gtest/gtest.h>

#include <unordered_map>

#include "core/rng.h"
#include "scenes/build/ground.h"
#include "scenes/build/scene_builder.h"
#include "scenes/catalog.h"
#include "scenes/solid_test.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec3;

const Paint kObject{"thing", Label::kObject, true};

TEST(GroundTruth, BoxOnTheGroundCountsAllButItsBottom) {
  SceneBuilder scene;
  AddFlatGround(scene, {{-5, -5}, {5, 5}});
  scene.Box(kObject, Vec3(-0.5, -1.0, 0.0), Vec3(0.5, 1.0, 1.5));
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.02);
  EXPECT_NEAR(truth.part_area_m2.at(0), 2.0 + 2 * 1.5 * (1.0 + 2.0), 0.01);
  for (const core::Vec3f& n : truth.normals) EXPECT_GT(n.z(), -0.5f);
}

TEST(GroundTruth, OverlappingBoxesCountTheSurfaceOfTheirUnion) {
  // A unit cube, and a box of 1 x 0.9 x 0.9 that reaches 0.4 m into it.
  SceneBuilder scene;
  scene.Box(kObject, Vec3(0, 0, 1), Vec3(1, 1, 2));
  scene.Box({"other", Label::kObject, true}, Vec3(0.6, 0.0, 1.0), Vec3(1.6, 0.9, 1.9));
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.01);
  // The second adds its far face and four strips; where both lie in the planes y = 0 and z = 1, the first
  // counts.
  const double first = 6.0 - 0.81, second = 0.81 + 4 * 0.6 * 0.9;
  EXPECT_NEAR(truth.part_area_m2.at(0), first, 0.02);
  EXPECT_NEAR(truth.part_area_m2.at(1), second, 0.02);
}

TEST(GroundTruth, TouchingFacesAreBuried) {
  SceneBuilder scene;
  scene.Box(kObject, Vec3(0, 0, 1), Vec3(1, 1, 2));
  scene.Box(kObject, Vec3(1, 0, 1), Vec3(2, 1, 2));
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.01);
  EXPECT_NEAR(truth.part_area_m2.at(0), 10.0, 0.02);
}

TEST(GroundTruth, OpenMeshBuriesNothing) {
  SceneBuilder scene;
  scene.Box(kObject, Vec3(0.25, 0.25, 1.25), Vec3(0.75, 0.75, 1.75));
  core::TriMesh open = MakeBox(Vec3(1, 1, 1), At(Vec3(0.5, 0.5, 1.5)));
  open.triangles.pop_back();
  scene.Visual({"open", Label::kWall}, open);
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.01);
  EXPECT_NEAR(truth.part_area_m2.at(0), 1.5, 1e-3);
}

TEST(GroundTruth, PointsAreOnePerSpacingSquaredEverywhere) {
  SceneBuilder scene;
  scene.Visual(kObject, MakeSphere(0.5, At(Vec3(0, 0, 2)), 64));
  scene.Box({"plank", Label::kObject, true}, Vec3(-3, 2, 2), Vec3(3, 2.004, 2.006));
  const SceneSpec spec = scene.Finish({3, 0}, 0);
  const double s = 0.01;
  const GroundTruth truth = SampleGroundTruth(spec, s);
  std::vector<double> count(truth.part_names.size(), 0.0);
  for (uint16_t part : truth.part) count[part] += s * s;
  // A plank far thinner than the spacing gets its share too.
  EXPECT_NEAR(count[0], truth.part_area_m2[0], 0.01 * truth.part_area_m2[0]);
  EXPECT_NEAR(count[1], truth.part_area_m2[1], 0.03 * truth.part_area_m2[1]);
  EXPECT_NEAR(truth.part_area_m2[0], spec.parts[0].mesh.AreaM2(), 1e-3);
}

TEST(GroundTruth, NeighboursOnAFaceStandOneSpacingApart) {
  SceneBuilder scene;
  scene.Box(kObject, Vec3(0, 0, 1), Vec3(1, 1, 2));
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.05);
  for (size_t i = 0; i < truth.points.size(); ++i) {
    double nearest = 1e9;
    for (size_t j = 0; j < truth.points.size(); ++j) {
      if (i == j || truth.normals[i].dot(truth.normals[j]) < 0.9f) continue;
      nearest = std::min<double>(nearest, (truth.points[i] - truth.points[j]).norm());
    }
    ASSERT_NEAR(nearest, 0.05, 1e-4);
  }
}

TEST(GroundTruth, SameSceneGivesTheSameBytes) {
  const SceneSpec scene = LoadScene("car");
  const GroundTruth a = SampleGroundTruth(scene, 0.02), b = SampleGroundTruth(scene, 0.02);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.part_area_m2, b.part_area_m2);
}

TEST(SolidTest, AgreesWithSphereAndBoxMembershipOnRandomPoints) {
  const core::TriMesh sphere = MakeSphere(0.8, At(Vec3(0, 0, 0)), 96);
  const core::TriMesh box = MakeBox(Vec3(0.5, 0.6, 0.7), At(Vec3(0.7, 0, 0)));
  const SolidTest solid({&sphere, &box});
  core::Rng rng(3);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 p(rng.Uniform(-1.5, 1.5), rng.Uniform(-1.5, 1.5), rng.Uniform(-1.5, 1.5));
    const double to_sphere = p.norm() - 0.8,
                 to_box = ((p - Vec3(0.7, 0, 0)).cwiseAbs() - Vec3(0.5, 0.6, 0.7)).maxCoeff();
    if (std::abs(to_sphere) < 2e-3) continue;
    ASSERT_EQ(solid.IsInside(p), to_sphere < 0 || to_box < 0) << p.transpose();
  }
}

TEST(SolidTest, LinesThroughSharedEdgesAndCornersCountOnce) {
  const core::TriMesh box = MakeBox(Vec3(1, 1, 1), At(Vec3(0, 0, 0)));
  const SolidTest solid({&box});
  for (double x : {-0.5, 0.0, 0.5}) {
    for (double y : {-0.5, 0.0, 0.5}) {
      EXPECT_TRUE(solid.IsInside(Vec3(x, y, 0)));
      EXPECT_FALSE(solid.IsInside(Vec3(x, y, 1.5)));
      EXPECT_FALSE(solid.IsInside(Vec3(x, y, -1.5)));
    }
  }
}

}  // namespace
}  // namespace atlas::scenes
