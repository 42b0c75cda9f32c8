#include "sim/sensors/raycaster.h"

#include <gtest/gtest.h>

#include "tests/support/sensor_scenes.h"

namespace atlas::sim {
namespace {

using namespace testing;  // NOLINT

constexpr double kExtentM = 4.0;

/// Triangles of all shapes and sizes that cross one another.
core::TriMesh Soup(core::Rng* rng, int triangles) {
  core::TriMesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const core::Vec3 a = RandomPose(rng, kExtentM).translation();
    const double size = rng->Uniform(0.05, 3.0);
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.push_back((a + size * RandomDirection(rng)).cast<float>());
    }
    const auto n = static_cast<uint32_t>(3 * i);
    mesh.triangles.push_back({n, n + 1, n + 2});
  }
  return mesh;
}

/// Share of rays whose hit or miss, range and part differ from the oracle's. Rays through an edge may differ.
double ShareThatDiffers(const std::vector<RayHit>& hits, const std::vector<core::Ray>& rays,
                        const std::vector<core::TriMesh>& meshes, double max_range_m, int first_body) {
  size_t differ = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    int mesh = -1;
    const double range = BruteForceRange(meshes, rays[i], max_range_m, &mesh);
    const int32_t part = mesh < first_body ? mesh : kMovingBody + mesh - first_body;
    const bool same = range < 0.0 ? hits[i].range_m < 0.0f
                                  : std::abs(hits[i].range_m - range) < 1e-4 && hits[i].part == part;
    differ += same ? 0 : 1;
  }
  return static_cast<double>(differ) / static_cast<double>(rays.size());
}

TEST(RaycasterTest, MeshHitsEqualBruteForce) {
  core::Rng rng(1);
  const std::vector<core::TriMesh> meshes = {Soup(&rng, 120), Soup(&rng, 60),
                                             BoxMesh({1, 2, 0.5}, RandomPose(&rng, 1))};
  const Raycaster raycaster(Scene({Part(meshes[0]), Part(meshes[1]), Part(meshes[2])}));
  const std::vector<core::Ray> rays = RandomRays(&rng, 10007, 2.0 * kExtentM);
  std::vector<RayHit> hits(rays.size());
  raycaster.Cast(rays, 6.0f, 1, 1, hits);
  EXPECT_LT(ShareThatDiffers(hits, rays, meshes, 6.0, 1000), 5e-4);
}

TEST(RaycasterTest, MovingBodiesAreMetWhereTheyStand) {
  core::Rng rng(2);
  const core::TriMesh wall = Soup(&rng, 40);
  Raycaster raycaster(Scene({Part(wall)}));
  const std::vector<core::TriMesh> bodies = {BoxMesh({0.5, 0.3, 0.2}), Soup(&rng, 10),
                                             SphereMesh(0.7, 16, core::Pose::Identity())};
  for (size_t i = 0; i < bodies.size(); ++i) EXPECT_EQ(raycaster.AddBody(bodies[i]), static_cast<int>(i));
  for (int placement = 0; placement < 4; ++placement) {
    std::vector<core::TriMesh> meshes = {wall};
    for (size_t i = 0; i < bodies.size(); ++i) {
      const core::Pose T_map_body = RandomPose(&rng, kExtentM);
      raycaster.SetBodyPose(static_cast<int>(i), T_map_body);
      meshes.push_back(bodies[i]);
      meshes.back().Transform(T_map_body);
    }
    raycaster.CommitPoses();
    const std::vector<core::Ray> rays = RandomRays(&rng, 3000, kExtentM);
    std::vector<RayHit> hits(rays.size());
    raycaster.Cast(rays, 20.0f, 1, 1, hits);
    EXPECT_LT(ShareThatDiffers(hits, rays, meshes, 20.0, 1), 1e-3);
    raycaster.CastStatic(rays, 20.0f, 1, hits);
    EXPECT_LT(ShareThatDiffers(hits, rays, {wall}, 20.0, 1), 1e-3);
  }
}

TEST(RaycasterTest, NormalsAreThoseOfTheTriangle) {
  const Raycaster raycaster(Scene({Part(BoxMesh({1, 1, 1}))}));
  const std::vector<core::Ray> rays = {{{5, 0.2f, 0.1f}, {-1, 0, 0}}, {{0.3f, 0.2f, 9}, {0, 0, -1}}};
  std::vector<RayHit> hits(2);
  raycaster.Cast(rays, 20.0f, 1, 1, hits);
  EXPECT_NEAR(hits[0].normal.normalized().x(), 1.0, 1e-6);
  EXPECT_NEAR(hits[1].normal.normalized().z(), 1.0, 1e-6);
}

TEST(RaycasterTest, NothingIsSeenBeyondMaxRange) {
  const Raycaster raycaster(Scene({Part(BoxMesh({1, 1, 1}))}));
  const std::vector<core::Ray> rays(3, {{5, 0, 0.1f}, {-1, 0, 0}});
  std::vector<RayHit> hits(3);
  raycaster.Cast(rays, 3.9999f, 1, 1, hits);
  EXPECT_LT(hits[0].range_m, 0.0f);
  raycaster.Cast(rays, 4.0001f, 1, 1, hits);
  EXPECT_NEAR(hits[0].range_m, 4.0f, 1e-5);
}

TEST(RaycasterTest, ThreadsDoNotChangeAHit) {
  core::Rng rng(3);
  Raycaster raycaster(Scene({Part(Soup(&rng, 500)), Part(Soup(&rng, 100), 0.5)}));
  raycaster.AddBody(BoxMesh({1, 1, 1}));
  raycaster.CommitPoses();
  const std::vector<core::Ray> rays = RandomRays(&rng, 4001, kExtentM);
  std::vector<RayHit> alone(rays.size()), together(rays.size());
  raycaster.Cast(rays, 20.0f, 7, 1, alone);
  for (const int threads : {2, 3, 8}) {
    raycaster.Cast(rays, 20.0f, 7, threads, together);
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(alone[i].range_m, together[i].range_m);
      ASSERT_EQ(alone[i].part, together[i].part);
    }
  }
}

/// Parallel rays along +x, a ray each square centimetre or so, through whatever stands there.
double ShareThatPasses(const Raycaster& raycaster, uint64_t seed, float range_m,
                       std::vector<bool>* passed = nullptr) {
  std::vector<core::Ray> rays;
  for (int i = 0; i < 300; ++i) {
    for (int j = 0; j < 300; ++j) rays.push_back({{-5, 0.01f * i - 1.5f, 0.01f * j - 1.5f}, {1, 0, 0}});
  }
  std::vector<RayHit> hits(rays.size());
  raycaster.Cast(rays, range_m, seed, 1, hits);
  size_t through = 0;
  for (const RayHit& hit : hits) {
    through += hit.range_m < 0.0f ? 1 : 0;
    if (passed != nullptr) passed->push_back(hit.range_m < 0.0f);
  }
  return static_cast<double>(through) / static_cast<double>(rays.size());
}

TEST(RaycasterTest, ScreenPassesItsShareOfRaysOnceHoweverManyFacesItHas) {
  const Raycaster one(Scene({Part(BoxMesh({0.1, 2, 2}), 0.6)}));
  EXPECT_NEAR(ShareThatPasses(one, 11, 50.0f), 0.6, 4.0 * std::sqrt(0.24 / 90000));
  core::Pose behind = core::Pose::Identity();
  behind.translation().x() = 3.0;
  const Raycaster two(Scene({Part(BoxMesh({0.1, 2, 2}), 0.6), Part(BoxMesh({0.1, 2, 2}, behind), 0.6)}));
  EXPECT_NEAR(ShareThatPasses(two, 11, 50.0f), 0.36, 4.0 * std::sqrt(0.36 * 0.64 / 90000));
}

TEST(RaycasterTest, ScreenRepeatsWithItsSeedAndChangesWithAnother) {
  const Raycaster screen(Scene({Part(BoxMesh({0.1, 2, 2}), 0.5)}));
  std::vector<bool> first, again, other;
  ShareThatPasses(screen, 1, 50.0f, &first);
  ShareThatPasses(screen, 1, 50.0f, &again);
  ShareThatPasses(screen, 2, 50.0f, &other);
  EXPECT_EQ(first, again);
  size_t equal = 0;
  for (size_t i = 0; i < first.size(); ++i) equal += first[i] == other[i] ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(equal) / static_cast<double>(first.size()), 0.5, 0.01);
}

TEST(RaycasterTest, RaysThroughAScreenMeetWhatIsBehind) {
  core::Pose behind = core::Pose::Identity();
  behind.translation().x() = 3.0;
  const Raycaster raycaster(Scene({Part(BoxMesh({0.1, 2, 2}), 0.5), Part(BoxMesh({0.1, 2, 2}, behind))}));
  const std::vector<core::Ray> rays(1000, {{-5, 0.01f, 0.02f}, {1, 0, 0}});
  std::vector<RayHit> hits(rays.size());
  raycaster.Cast(rays, 50.0f, 1, 1, hits);
  for (const RayHit& hit : hits) EXPECT_NEAR(hit.range_m, hit.part == 0 ? 4.9 : 7.9, 1e-4);
  raycaster.CastStatic(rays, 50.0f, 1, hits);
  for (const RayHit& hit : hits) EXPECT_EQ(hit.part, 0);
}

TEST(RaycasterTest, EmptySceneIsVoid) {
  const Raycaster raycaster{scenes::SceneSpec{}};
  std::vector<RayHit> hits(1);
  raycaster.Cast(std::vector<core::Ray>{{{0, 0, 0}, {1, 0, 0}}}, 10.0f, 1, 1, hits);
  EXPECT_LT(hits[0].range_m, 0.0f);
}

TEST(RaycasterTest, NearBodyIsDistanceToItsSurface) {
  Raycaster raycaster{scenes::SceneSpec{}};
  const core::Vec3 half(0.5, 0.3, 0.2);
  raycaster.AddBody(BoxMesh(half));
  core::Rng rng(5);
  const core::Pose T_map_body = RandomPose(&rng, 2.0);
  raycaster.SetBodyPose(0, T_map_body);
  for (int i = 0; i < 4000; ++i) {
    const core::Vec3 p = core::Vec3(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
    const core::Vec3 q = p.cwiseAbs() - half;  // signed distance of a box
    const double distance = std::abs(q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0));
    if (std::abs(distance - 0.1) < 1e-5) continue;
    EXPECT_EQ(raycaster.NearBody(T_map_body * p, 0.1), distance < 0.1);
    EXPECT_GE(raycaster.BodyReach(T_map_body * p), (p.cwiseAbs() + half).norm() - 1e-6);
  }
}

}  // namespace
}  // namespace atlas::sim
