// Meshes of fields that are set from a closed form: what marching cubes alone does.

#include <gtest/gtest.h>

#include "mapping/meshing/marching_cubes.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/field_of_shape.h"
#include "tests/support/mesh_cracks.h"

namespace atlas {
namespace {

using core::Vec3;
using mapping::TsdfField;
using mapping::TsdfOctree;

constexpr double kResolution = 0.065;

TsdfOctree TsdfOf(const tests::AnalyticShape& shape, const core::Box3& box) {
  TsdfOctree map(kResolution);
  tests::FillOctree<TsdfField>(
      box, [&](const Vec3& p) { return tests::TsdfAt(shape.Distance(p), 4 * kResolution, kResolution); },
      &map);
  return map;
}

void ExpectExact(const tests::AnalyticShape& shape, const core::Box3& box, size_t* border_edges) {
  const TsdfOctree map = TsdfOf(shape, box);
  const core::TriMesh mesh = ExtractMesh(map, {});
  ASSERT_GT(mesh.triangles.size(), 1000u);
  const tests::MeshFaults faults = tests::FindFaults(mesh, map);
  EXPECT_TRUE(faults.None()) << faults.cracks << " cracks, " << faults.crowded << " crowded, "
                             << faults.flipped << " flipped, " << faults.degenerate << " degenerate";
  *border_edges = faults.border_edges;
  const tests::MeshError error = tests::ErrorOf(mesh, shape);
  EXPECT_LT(error.mean_m, 0.05 * kResolution);
  EXPECT_LT(error.worst_m, 0.5 * kResolution);
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
               c = mesh.vertices[t[2]].cast<double>();
    const Vec3 n = (b - a).cross(c - a);
    if (n.norm() < 1e-5) continue;
    ASSERT_GT(n.dot(shape.Normal((a + b + c) / 3.0)), 0.0) << "faces away from free space";
  }
}

TEST(MeshOfField, SphereIsClosedAndExact) {
  size_t border;
  ExpectExact(tests::Sphere(Vec3(0.31, -0.17, 0.42), 1.2), {Vec3::Constant(-2), Vec3::Constant(2)}, &border);
  EXPECT_EQ(border, 0u);
}
TEST(MeshOfField, TorusIsClosedAndExact) {
  size_t border;
  ExpectExact(tests::Torus(Vec3(0.1, 0.2, -0.3), 1.1, 0.4), {Vec3::Constant(-2.5), Vec3::Constant(2.5)},
              &border);
  EXPECT_EQ(border, 0u);
}
TEST(MeshOfField, TurnedBoxIsClosedAndExact) {
  size_t border;
  const core::Mat3 R = core::RotationFromYawPitchRoll(0.4, 0.3, -0.7);
  ExpectExact(tests::SolidBox(Vec3(0.1, 0.2, -0.3), Vec3(1.0, 0.7, 0.5), R),
              {Vec3::Constant(-2.5), Vec3::Constant(2.5)}, &border);
  EXPECT_EQ(border, 0u);
}
TEST(MeshOfField, PlaneEndsWhereObservedSpaceEnds) {
  size_t border;
  ExpectExact(tests::HalfSpace(Vec3(0, 0, 0.2), Vec3(0.2, -0.3, 1.0)),
              {Vec3::Constant(-2), Vec3::Constant(2)}, &border);
  EXPECT_GT(border, 100u);
}

}  // namespace
}  // namespace atlas
