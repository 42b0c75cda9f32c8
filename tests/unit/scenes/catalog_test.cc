#include "scenes/catalog.h"

#include <gtest/gtest.h>

#include "core/errors.h"
#include "scenes/build/ground.h"
#include "scenes/solid_test.h"
#include "tests/unit/scenes/mesh_checks.h"

namespace atlas::scenes {
namespace {

using core::Vec3;

class EveryScene : public ::testing::TestWithParam<std::string> {
 protected:
  SceneSpec scene_ = LoadScene(GetParam());
};

TEST_P(EveryScene, IsMadeOfClosedOutwardFacingSolids) {
  for (const ScenePart& part : scene_.parts) {
    EXPECT_EQ(UnpairedEdges(part.mesh), 0) << part.name;
    EXPECT_GT(LeastShellVolume(part.mesh), 0.0) << part.name;
  }
}

TEST_P(EveryScene, SpawnIsFreeOnTheGroundAndClearOfTheObject) {
  std::vector<const core::TriMesh*> shells;
  for (const ScenePart& part : scene_.parts) shells.push_back(&part.mesh);
  const SolidTest solids(shells);
  const core::Pose& T = scene_.T_map_spawn;
  EXPECT_EQ(T.translation().z(), 0.0);
  for (double x = -0.7; x <= 0.7; x += 0.1) {
    for (double y = -0.45; y <= 0.45; y += 0.1) {
      EXPECT_TRUE(solids.IsInside(T * Vec3(x, y, -0.06))) << x << " " << y;
      for (double z : {0.06, 0.3, 0.6, 0.9})
        EXPECT_FALSE(solids.IsInside(T * Vec3(x, y, z))) << x << " " << y;
    }
  }
  const double distance = scene_.object_box.DistanceTo(T.translation() + Vec3(0, 0, 0.5));
  if (scene_.is_space) {
    EXPECT_EQ(distance, 0.0);
    return;
  }
  EXPECT_GE(distance, 2.0);
  EXPECT_LE(distance, 3.5);
}

TEST_P(EveryScene, ObjectBoxIsTightAndExcludesTheGround) {
  if (scene_.is_space) return;
  const GroundTruth truth = SampleGroundTruth(scene_, 0.05);
  core::Box3 extent;
  for (const core::Vec3f& p : truth.points) {
    EXPECT_GE(p.z(), -0.1f);
    extent.Extend(p.cast<double>());
    Vec3 raised = p.cast<double>();
    raised.z() = std::max(raised.z(), scene_.object_box.min.z());
    ASSERT_TRUE(scene_.object_box.Contains(raised));
  }
  EXPECT_GE(scene_.object_box.min.z(), 0.03);
  EXPECT_LE((scene_.object_box.max - extent.max).maxCoeff(), 0.45);
  EXPECT_LE((extent.min - scene_.object_box.min).head<2>().maxCoeff(), 0.3);
  EXPECT_TRUE(scene_.bounds.Contains(scene_.object_box.Center()));
}

TEST_P(EveryScene, OfASpaceHasItsGroundAndNearlyAllItsTruthInTheBox) {
  if (!scene_.is_space) return;
  EXPECT_GT(scene_.truth_spacing_m, 0.01);
  const GroundTruth truth = SampleGroundTruth(scene_, 6.0 * scene_.truth_spacing_m);
  size_t inside = 0, low = 0;
  for (const core::Vec3f& p : truth.points) {
    inside += scene_.object_box.Contains(p.cast<double>());
    low += std::abs(p.z()) < 0.1f;
  }
  EXPECT_GT(static_cast<double>(inside), 0.95 * static_cast<double>(truth.points.size()));
  EXPECT_GT(static_cast<double>(low), 0.05 * static_cast<double>(truth.points.size()));
  EXPECT_TRUE(scene_.bounds.Inflated(0.2).Contains(scene_.object_box.min));
  EXPECT_TRUE(scene_.bounds.Inflated(0.2).Contains(scene_.object_box.max));
}

TEST_P(EveryScene, KeepsPhysicsLightAndItsHullsConvex) {
  size_t shapes = 0;
  for (const ScenePart& part : scene_.parts) {
    shapes += part.collision.size();
    for (const CollisionShape& shape : part.collision) {
      if (const auto* hull = std::get_if<HullShape>(&shape.shape)) {
        EXPECT_EQ(UnpairedEdges(hull->mesh), 0) << part.name;
        EXPECT_GT(VolumeByFlux(hull->mesh), 0.0) << part.name;
        EXPECT_LE(hull->mesh.vertices.size(), 130u) << part.name;
      }
    }
  }
  EXPECT_LE(shapes, scene_.is_space ? 400u : 150u);
}

TEST_P(EveryScene, BoxShapesFillExactlyWhatRaysSee) {
  // The corners of every box in physics, drawn in by 2 mm, lie inside the part's own mesh or what it stands
  // for.
  for (const ScenePart& part : scene_.parts) {
    const SolidTest solid({&part.mesh});
    for (const CollisionShape& shape : part.collision) {
      const auto* box = std::get_if<BoxShape>(&shape.shape);
      if (box == nullptr || part.name == "benches" || part.name == "porch_railing") continue;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const Vec3 p = sign.cwiseProduct((box->half_size.array() - 2e-3).matrix());
        EXPECT_TRUE(solid.IsInside(shape.T_map_shape * p)) << part.name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Catalog, EveryScene, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const CatalogEntry& entry : Catalog()) names.push_back(entry.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

TEST(Catalog, UnknownNameSuggestsTheNearOne) {
  try {
    LoadScene("helicoptr");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'helicopter'"), std::string::npos) << error.what();
  }
}

TEST(Helicopter, DeckHasTwoStairwellsAndSolidWalkwayAllAround) {
  const SceneSpec scene = LoadScene("helicopter");
  std::vector<const core::TriMesh*> deck;
  for (const ScenePart& part : scene.parts) {
    if (part.name == "deck") deck.push_back(&part.mesh);
  }
  const SolidTest solid(deck);
  double hole_area = 0.0;
  for (double x = -7.975; x < 8.0; x += 0.05) {
    for (double y = -6.975; y < 7.0; y += 0.05) {
      const bool there = solid.IsInside(Vec3(x, y, -0.05));
      if (!there) hole_area += 0.0025;
      const bool walkway = scene.object_box.Inflated(2.5).Contains(Vec3(x, y, 0.5));
      if (walkway && std::hypot(std::abs(x) - 5.85, std::abs(y) - 5.4) > 2.0) {
        EXPECT_TRUE(there) << x << " " << y;
      }
    }
  }
  EXPECT_NEAR(hole_area, 2 * 2.5 * 1.0, 0.3);
}

TEST(Helicopter, GratingLetsRaysThroughWherePlatesDoNot) {
  const SceneSpec plates = LoadScene("helicopter"), grating = LoadScene("helicopter_grating");
  ASSERT_EQ(plates.parts.size(), grating.parts.size());
  for (size_t i = 0; i < plates.parts.size(); ++i) {
    EXPECT_EQ(plates.parts[i].ray_transmission, 0.0);
    const bool deck = grating.parts[i].name == "deck";
    EXPECT_EQ(grating.parts[i].ray_transmission > 0.0, deck);
    EXPECT_EQ(grating.parts[i].collision.size(), plates.parts[i].collision.size());
  }
}

TEST(FacadeGrass, MeshAndHeightGridAreTheSameGround) {
  const SceneSpec scene = LoadScene("facade_grass");
  const ScenePart& grass = scene.parts.front();
  const auto& grid = std::get<HeightGridShape>(grass.collision.at(0).shape);
  float low = 1, high = -1;
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      const size_t i = static_cast<size_t>(row) * grid.cols + col;
      const core::Vec2 p = grid.origin + grid.spacing_m * core::Vec2(col, row);
      ASSERT_NEAR((grass.mesh.vertices[i] - core::Vec3(p.x(), p.y(), grid.height_m[i]).cast<float>()).norm(),
                  0, 1e-6);
      low = std::min(low, grid.height_m[i]);
      high = std::max(high, grid.height_m[i]);
    }
  }
  EXPECT_LT(low, -0.02f);
  EXPECT_GT(high, 0.02f);
  EXPECT_LE(std::max(-low, high), 0.04f);
}

}  // namespace
}  // namespace atlas::scenes
