// Ground truth against the meshes it stands for, for every scene: on them, and complete. Judged by
// tests/support/surface_oracle.h alone.
//
// The other tests of ground truth look at areas, counts and spacings, which an axis that is not quite in the
// plane of its face changes by parts in ten thousand, and at faces that are exactly level, upright or steep.
#include <gtest/gtest.h>

#include <map>

#include "scenes/build/scene_builder.h"
#include "scenes/catalog.h"
#include "tests/support/surface_oracle.h"

namespace atlas::scenes {
namespace {

using core::Vec3;

/// A scene and its truth, sampled once for all tests. Spaces are sampled coarsely: the same lattice, a
/// quarter of the points.
struct Sampled {
  explicit Sampled(const std::string& name)
      : scene(LoadScene(name)),
        spacing_m((scene.is_space ? 4.0 : 1.0) * scene.truth_spacing_m),
        truth(SampleGroundTruth(scene, spacing_m)),
        object(tests::TrianglesOf(scene, [](const ScenePart& part) { return part.is_object; })) {}

  SceneSpec scene;
  double spacing_m;
  GroundTruth truth;
  std::vector<tests::Triangle> object;
};

const Sampled& SampledScene(const std::string& name) {
  static std::map<std::string, Sampled> kept;
  return kept.try_emplace(name, name).first->second;
}

void ExpectNoneMissed(const SceneSpec& scene, const std::vector<tests::Triangle>& object,
                      const GroundTruth& truth, double spacing_m, int draws) {
  const auto solids = tests::TrianglesOf(scene, [](const ScenePart&) { return true; });
  const auto samples = tests::ExposedSamples(object, solids, draws, 11);
  ASSERT_GT(samples.size(), 0.1 * draws);
  const auto distances = tests::DistancesToPoints(samples, truth.points, 3.0 * spacing_m);
  double missed = 0.0;
  for (size_t i = 0; i < samples.size(); ++i) {
    missed += distances[i] > spacing_m;
    EXPECT_LE(distances[i], 1.25 * spacing_m)
        << samples[i].p.transpose() << " facing " << samples[i].normal.transpose();
  }
  EXPECT_LE(missed, std::max(1.0, 1e-3 * static_cast<double>(samples.size())));
}

class TruthOfEveryScene : public ::testing::TestWithParam<std::string> {};

TEST_P(TruthOfEveryScene, LiesOnTheMeshWithinATenthOfAMillimetre) {
  const Sampled& s = SampledScene(GetParam());
  const size_t stride = 1 + s.truth.points.size() / 150000;
  EXPECT_EQ(tests::CountOff(s.truth.points, s.object, 1e-4, stride), 0u) << "of " << s.truth.points.size();
}

TEST_P(TruthOfEveryScene, HasAPointWithinTheSpacingOfEveryExposedSurface) {
  const Sampled& s = SampledScene(GetParam());
  const auto draws = static_cast<int>(std::clamp<size_t>(15000000 / s.object.size(), 100, 3000));
  ExpectNoneMissed(s.scene, s.object, s.truth, s.spacing_m, draws);
}

INSTANTIATE_TEST_SUITE_P(Catalog, TruthOfEveryScene, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const CatalogEntry& entry : Catalog()) names.push_back(entry.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

/// A plate of 3 x 0.5 m, 2 cm thick, rolled and pitched, 40 m from the origin.
SceneSpec PlateScene(double roll_deg, double pitch_deg) {
  SceneBuilder scene;
  const core::Mat3 R = core::RotationFromYawPitchRoll(0.3, core::Radians(pitch_deg), core::Radians(roll_deg));
  scene.Box({"plate", core::Label::kObject, true}, Vec3(1.5, 0.25, 0.01),
            core::MakePose(R, Vec3(40.0, -25.0, 2.0)));
  return scene.Finish({37.0, -25.0}, 0.0);
}

TEST(GroundTruth, OfAPlateLiesOnItHoweverItIsTilted) {
  for (const double pitch : {0.0, 0.01, 1.0, 1.5, 2.5, 2.6, 45.0, 89.0, 90.0, 178.0}) {
    for (const double roll : {0.0, 2.0}) {
      const SceneSpec scene = PlateScene(roll, pitch);
      const auto plate = tests::TrianglesOf(scene, [](const ScenePart& part) { return part.is_object; });
      const GroundTruth truth = SampleGroundTruth(scene, 0.01);
      EXPECT_EQ(tests::CountOff(truth.points, plate, 1e-4, 1), 0u) << pitch << " " << roll;
      ExpectNoneMissed(scene, plate, truth, 0.01, 2000);
    }
  }
}

TEST(GroundTruth, OfASolidWhoseFacesLookInwardIsThatOfTheSameTurnedOut) {
  SceneBuilder out, in;
  const core::TriMesh box = MakeBox(Vec3(0.5, 0.4, 0.3), core::PoseFromXyzYaw(Vec3(0, 0, 2), 0.2));
  core::TriMesh inward = box;
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  out.Visual({"thing", core::Label::kObject, true}, box);
  in.Visual({"thing", core::Label::kObject, true}, inward);
  const GroundTruth a = SampleGroundTruth(out.Finish({3, 0}, 0), 0.02),
                    b = SampleGroundTruth(in.Finish({3, 0}, 0), 0.02);
  EXPECT_GT(a.points.size(), 1000u);
  EXPECT_NEAR(static_cast<double>(b.points.size()), static_cast<double>(a.points.size()), 60.0);
  for (size_t i = 0; i < b.points.size(); ++i) {
    EXPECT_GT(b.normals[i].dot(b.points[i] - core::Vec3f(0, 0, 2)), 0.0f);
    EXPECT_EQ(b.two_sided[i], 0);
  }
}

TEST(GroundTruth, OfASheetIsTwoSidedAndThatOfASolidIsNot) {
  core::TriMesh sheet;
  sheet.vertices = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  SceneBuilder scene;
  scene.Visual({"sheet", core::Label::kObject, true}, sheet);
  scene.Box({"box", core::Label::kObject, true}, Vec3(2, 0, 1), Vec3(3, 1, 2));
  const GroundTruth truth = SampleGroundTruth(scene.Finish({-3, 0}, 0), 0.05);
  for (size_t i = 0; i < truth.points.size(); ++i) EXPECT_EQ(truth.two_sided[i], truth.part[i] == 0 ? 1 : 0);
}

TEST(GroundTruth, OfTheObjectCountsWhereAnotherSurfaceCoincides) {
  SceneBuilder scene;
  scene.Box({"shelf", core::Label::kWall, false}, Vec3(0, 0, 1), Vec3(1, 1, 2));
  scene.Box({"thing", core::Label::kObject, true}, Vec3(0.2, 0.2, 1.2), Vec3(0.8, 0.8, 2));  // flush on top
  const GroundTruth truth = SampleGroundTruth(scene.Finish({3, 0}, 0), 0.01);
  EXPECT_NEAR(truth.part_area_m2.at(0), 0.36, 0.01);
}

}  // namespace
}  // namespace atlas::scenes
