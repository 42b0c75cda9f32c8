#include "scenes/build/shapes.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "scenes/build/convex_hull.h"
#include "scenes/build/openings.h"
#include "scenes/build/triangle_prisms.h"
#include "scenes/build/triangulate.h"
#include "scenes/solid_test.h"
#include "tests/unit/scenes/mesh_checks.h"

namespace atlas::scenes {
namespace {

using core::kPi;
using core::Pose;
using core::TriMesh;
using core::Vec2;
using core::Vec3;

const Pose kTilted = core::MakePose(core::RotationFromYawPitchRoll(0.7, -0.4, 1.1), Vec3(3.0, -2.0, 1.5));

void ExpectSolid(const TriMesh& mesh, double volume, double area, double relative) {
  EXPECT_EQ(UnpairedEdges(mesh), 0);
  EXPECT_TRUE(IsWatertight(mesh));
  EXPECT_NEAR(VolumeByFlux(mesh), volume, relative * volume);
  EXPECT_NEAR(mesh.AreaM2(), area, relative * area);
}

TEST(Shapes, PrimitivesHaveClosedFormVolumeAndArea) {
  const double n = 64, polygon = 0.5 * n * std::sin(2 * kPi / n), side = 2 * n * std::sin(kPi / n);
  ExpectSolid(MakeBox({0.5, 1.0, 1.5}, kTilted), 6.0, 22.0, 1e-5);
  ExpectSolid(MakeCylinder(0.4, 0.7, kTilted, 64), polygon * 0.16 * 1.4,
              2 * polygon * 0.16 + side * 0.4 * 1.4, 1e-5);
  ExpectSolid(MakeSphere(0.5, kTilted, 128), 4.0 / 3.0 * kPi * 0.125, kPi, 4e-3);
  ExpectSolid(MakeCapsule(0.5, 0.8, kTilted, 128), 4.0 / 3.0 * kPi * 0.125 + kPi * 0.25 * 1.6,
              kPi + kPi * 1.6, 4e-3);
  ExpectSolid(MakeFrustum(0.6, 0.3, 0.5, kTilted, 256), kPi / 3 * (0.36 + 0.18 + 0.09),
              kPi * (0.36 + 0.09) + kPi * 0.9 * std::hypot(0.3, 1.0), 1e-3);
}

TEST(Shapes, ConcaveOutlineIsFilledExactly) {
  const std::vector<Vec2> u = {{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  ExpectSolid(MakeExtrusion(u, -0.25, 0.5, kTilted), 5 * 0.75, 10 + 12 * 0.75, 1e-5);
  for (const auto& t : TriangulatePolygon(u)) EXPECT_GT(Cross(u[t[0]], u[t[1]], u[t[2]]), 0.0);
}

TEST(Shapes, BentTubeKeepsItsCrossSection) {
  const std::vector<Vec3> path = {{0, 0, 0}, {1, 0, 0}, {1.7, 0.7, 0}, {1.7, 0.7, 1}};
  const TriMesh tube = MakeTube(path, 0.05, 48);
  EXPECT_EQ(UnpairedEdges(tube), 0);
  const double length = 1 + std::hypot(0.7, 0.7) + 1, section = 0.5 * 48 * std::sin(2 * kPi / 48) * 0.0025;
  EXPECT_NEAR(VolumeByFlux(tube), section * length, 1e-4 * section * length);
}

TEST(Shapes, PatchOverACylinderStandsProudByTheSameAmountEverywhere) {
  std::vector<Ring> rings;
  for (int i = 0; i <= 20; ++i) {
    Ring ring;
    for (int j = 0; j < 72; ++j) ring.emplace_back(0.1 * i, std::cos(j * kPi / 36), std::sin(j * kPi / 36));
    rings.push_back(ring);
  }
  const TriMesh patch = MakeLoftPatch(rings, 5, 15, -6, 9, 0.03, 0.02);
  EXPECT_EQ(UnpairedEdges(patch), 0);
  EXPECT_GT(VolumeByFlux(patch), 0.0);
  for (const core::Vec3f& v : patch.vertices) {
    const double r = std::hypot(v.y(), v.z());
    EXPECT_TRUE(std::abs(r - 1.03) < 1e-5 || std::abs(r - 0.98) < 1e-5) << r;
  }
}

TEST(Openings, CoverEqualsOutlineLessHolesOnEverySample) {
  const Rect outer{{0, 0}, {10, 4}};
  const std::vector<Rect> holes = {
      {{1, 1}, {2, 3}}, {{3, 0}, {4, 2.5}}, {{3.5, 3}, {6, 3.5}}, {{8, 1}, {9, 3}}};
  const auto in = [](const Rect& r, const Vec2& p) {
    return p.x() > r.min.x() && p.x() < r.max.x() && p.y() > r.min.y() && p.y() < r.max.y();
  };
  core::Rng rng(1);
  const std::vector<Rect> cover = CoverAround(outer, holes);
  for (int k = 0; k < 20000; ++k) {
    const Vec2 p(rng.Uniform(0, 10), rng.Uniform(0, 4));
    int holes_here = 0, covers_here = 0;
    for (const Rect& r : holes) holes_here += in(r, p);
    for (const Rect& r : cover) covers_here += in(r, p);
    ASSERT_EQ(covers_here, holes_here > 0 ? 0 : 1) << p.transpose();
  }
}

TEST(ConvexHull, HoldsEveryCornerAndIsClosed) {
  core::Rng rng(7);
  std::vector<core::Vec3f> points;
  for (int k = 0; k < 40; ++k) points.emplace_back(rng.Normal(), rng.Normal(), rng.Normal());
  const TriMesh hull = ConvexHull(points);
  EXPECT_EQ(UnpairedEdges(hull), 0);
  EXPECT_TRUE(IsConvex(hull));
  for (const auto& t : hull.triangles) {
    const Vec3 a = hull.vertices[t[0]].cast<double>(), b = hull.vertices[t[1]].cast<double>(),
               c = hull.vertices[t[2]].cast<double>();
    const Vec3 normal = (b - a).cross(c - a).normalized();
    for (const core::Vec3f& p : points) EXPECT_LT(normal.dot(p.cast<double>() - a), 1e-4);
  }
}

TEST(ConvexHull, OfABoxIsTheBoxAndOfAFlatSheetIsEmpty) {
  const TriMesh box = MakeBox({0.5, 1.0, 1.5}, kTilted);
  EXPECT_NEAR(VolumeByFlux(ConvexHull(box.vertices)), 6.0, 1e-4);
  EXPECT_TRUE(ConvexHull({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0.5f, 0}}).triangles.empty());
}

TEST(TrianglePrisms, LieBehindTheirFacesAndStopAtReach) {
  const TriMesh wall = MakeBox({0.2, 2.0, 2.0}, core::MakePose(core::Mat3::Identity(), Vec3(0, 0, 2.0)));
  const auto prisms = TrianglePrisms(wall, {});
  // The top is out of reach: ten of twelve triangles are left.
  EXPECT_EQ(prisms.size(), 10u);
  for (const CollisionShape& prism : prisms) {
    const TriMesh& mesh = std::get<HullShape>(prism.shape).mesh;
    EXPECT_EQ(UnpairedEdges(mesh), 0);
    EXPECT_GT(VolumeByFlux(mesh), 0.0);
    EXPECT_TRUE(wall.Bounds().Inflated(1e-5).Contains(mesh.Bounds().min));
    EXPECT_TRUE(wall.Bounds().Inflated(1e-5).Contains(mesh.Bounds().max));
  }
}

TEST(TrianglePrisms, FineMeshIsSimplifiedToTheBoundNearItsSurface) {
  const TriMesh ball = MakeSphere(0.6, core::MakePose(core::Mat3::Identity(), Vec3(0, 0, 0.6)), 96);
  PrismOptions options;
  const auto prisms = TrianglePrisms(ball, options);
  ASSERT_GT(ball.triangles.size(), 4000u);
  EXPECT_LE(prisms.size(), 600u);
  EXPECT_GT(prisms.size(), 100u);
  for (const CollisionShape& prism : prisms) {
    for (const core::Vec3f& v : std::get<HullShape>(prism.shape).mesh.vertices) {
      const double r = (v.cast<double>() - Vec3(0, 0, 0.6)).norm();
      EXPECT_NEAR(r, 0.6, 0.08);
    }
  }
}

}  // namespace
}  // namespace atlas::scenes
