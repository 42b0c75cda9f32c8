#include "scenes/truth_check.h"

#include <gtest/gtest.h>

#include "scenes/build/scene_builder.h"

namespace atlas::scenes {
namespace {

using core::Vec3;

SceneSpec BoxScene() {
  SceneBuilder scene;
  scene.Box({"thing", core::Label::kObject, true}, Vec3(0, 0, 1), Vec3(1, 1, 2));
  return scene.Finish({3, 0}, 0);
}

TEST(TruthCheck, AcceptsTheTruthOfABox) {
  const SceneSpec scene = BoxScene();
  const TruthReport report = CheckTruth(scene, SampleGroundTruth(scene, 0.02), 0.02, 5000);
  EXPECT_TRUE(report.good());
  EXPECT_EQ(report.off_mesh, 0u);
  EXPECT_EQ(report.exposed, 5000u);
  EXPECT_LT(report.greatest_m, 1e-6);
}

TEST(TruthCheck, MeasuresPointsThatLieOffTheMesh) {
  const SceneSpec scene = BoxScene();
  GroundTruth truth = SampleGroundTruth(scene, 0.02);
  truth.points[7] += 0.3f * truth.normals[7];
  truth.points[9] += 0.001f * truth.normals[9];
  const TruthReport report = CheckTruth(scene, truth, 0.02, 2000);
  EXPECT_FALSE(report.good());
  EXPECT_EQ(report.off_mesh, 2u);
  EXPECT_NEAR(report.greatest_m, 0.3, 1e-6);
  EXPECT_NEAR(report.mean_m, 0.301 / static_cast<double>(truth.points.size()), 1e-8);
}

TEST(TruthCheck, FindsSurfaceWithoutTruth) {
  const SceneSpec scene = BoxScene();
  GroundTruth truth = SampleGroundTruth(scene, 0.02), part;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    if ((truth.points[i] - core::Vec3f(0.5f, 0.5f, 2.0f)).norm() < 0.08f) continue;
    part.points.push_back(truth.points[i]);
  }
  const TruthReport report = CheckTruth(scene, part, 0.02, 20000);
  EXPECT_FALSE(report.good());
  EXPECT_EQ(report.off_mesh, 0u);
  EXPECT_GT(report.missed, 10u);
  EXPECT_NEAR((report.worst_gap_map - Vec3(0.5, 0.5, 2.0)).norm(), 0.0, 0.05);
}

TEST(TruthCheck, NamesOpenAndInwardPieces) {
  SceneSpec scene = BoxScene();
  ScenePart inward = scene.parts.front(), open = scene.parts.front();
  inward.name = "inward";
  for (auto& t : inward.mesh.triangles) std::swap(t[0], t[1]);
  open.name = "open";
  open.mesh.triangles.pop_back();
  scene.parts = {scene.parts.front(), inward, open};
  const std::vector<PartReport> reports = CheckParts(scene);
  ASSERT_EQ(reports.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(reports[i].shells, 1u);
    EXPECT_EQ(reports[i].inward_shells, i == 1 ? 1u : 0u);
    EXPECT_EQ(reports[i].open_shells, i == 2 ? 1u : 0u);
    EXPECT_EQ(reports[i].flat_triangles, 0u);
  }
}

}  // namespace
}  // namespace atlas::scenes
