// Meshes of fields that are set from a closed form: what marching cubes alone does.

#include <gtest/gtest.h>

#include "mapping/integrator/write/occupancy_shift.h"
#include "mapping/meshing/marching_cubes.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/field_of_shape.h"
#include "tests/support/mesh_cracks.h"

namespace atlas {
namespace {

using core::Vec3;
using mapping::OccupancyField;
using mapping::OccupancyOctree;
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

/// What scans without noise leave: Eq. 4.2's ramp about the surface moved by OccupancyShift, `scans` times.
OccupancyField::Value OccupancyAt(const tests::AnalyticShape& shape, const Vec3& p, int scans) {
  const double support_m = mapping::OccupancyShift(shape.Normal(p), kResolution);
  const double behind_m = support_m - shape.Distance(p);
  constexpr double kRamp_m = 0.045, kUnits = 8.0;
  if (behind_m > 0.13) return 0;
  return tests::OccupancyAt(scans * std::lround(kUnits * std::clamp(behind_m / kRamp_m, -1.0, 1.0)),
                            behind_m / (2.0 * support_m));
}
OccupancyOctree OccupancyOf(const tests::AnalyticShape& shape, const core::Box3& box, int scans) {
  OccupancyOctree map(kResolution);
  tests::FillOctree<OccupancyField>(
      box, [&](const Vec3& p) { return OccupancyAt(shape, p, scans); }, &map);
  return map;
}

TEST(MeshOfField, OccupancyIsMovedBackOntoTheSurface) {
  const tests::SolidBox box(Vec3(0.1, 0.2, -0.3), Vec3(1.0, 0.7, 0.5),
                            core::RotationFromYawPitchRoll(0.4, 0.3, -0.7));
  const tests::Sphere sphere(Vec3(0.31, -0.17, 0.42), 1.2);
  for (const tests::AnalyticShape* shape :
       {static_cast<const tests::AnalyticShape*>(&box), static_cast<const tests::AnalyticShape*>(&sphere)}) {
    for (const int scans : {1, 4, 10}) {
      const OccupancyOctree map = OccupancyOf(*shape, {Vec3::Constant(-2), Vec3::Constant(2)}, scans);
      EXPECT_GT(ErrorOf(ExtractMesh(map, {.undo_shift = false}), *shape).bias_m, 0.5 * kResolution);
      const tests::MeshError error = ErrorOf(ExtractMesh(map, {}), *shape);
      EXPECT_LT(error.mean_m, 0.08 * kResolution);
      // Places are known to a quarter of a voxel.
      EXPECT_LT(std::abs(error.bias_m), 0.07 * kResolution);
    }
  }
}

/// `sway_voxels`: how far the sheet's steps sway about its middle.
void ExpectSidesApart(const Vec3& normal, double sway_voxels) {
  // One voxel thick: both sides want to move by most of a voxel.
  OccupancyOctree map(kResolution);
  const Vec3 point = Vec3::Constant(0.5 * kResolution);
  tests::FillOctree<OccupancyField>(
      {Vec3::Constant(-1), Vec3::Constant(1)},
      [&](const Vec3& p) -> OccupancyField::Value {
        return std::abs(normal.dot(p - point)) < 0.6 * kResolution ? 30 : -40;
      },
      &map);
  const core::TriMesh mesh = ExtractMesh(map, {}), raw = ExtractMesh(map, {.undo_shift = false});
  ASSERT_EQ(mesh.triangles, raw.triangles);
  size_t turned = 0;
  for (const auto& t : mesh.triangles) {
    const auto normal_of = [&t](const core::TriMesh& m) {
      return (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]).eval();
    };
    turned += normal_of(mesh).dot(normal_of(raw)) < 0.0f;
  }
  EXPECT_LT(static_cast<double>(turned), 0.01 * static_cast<double>(mesh.triangles.size()));
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double before = normal.dot(raw.vertices[v].cast<double>() - point),
                 after = normal.dot(mesh.vertices[v].cast<double>() - point);
    if (std::abs(before) < 0.3 * kResolution) continue;
    ASSERT_GE(before > 0.0 ? after : -after, -sway_voxels * kResolution);
  }
}

TEST(MeshOfField, ThinSheetsKeepTheirTwoSidesApart) {
  ExpectSidesApart(Vec3::UnitZ(), 0.0);
  ExpectSidesApart(Vec3(0.3, 0.2, 1.0).normalized(), 0.35);
  ExpectSidesApart(Vec3(1.0, -0.9, 0.8).normalized(), 0.35);
}

TEST(MeshOfField, CollapsingEqualBlocksChangesNothing) {
  const tests::Sphere sphere(Vec3(0.31, -0.17, 0.42), 1.2);
  OccupancyOctree map = OccupancyOf(sphere, {Vec3::Constant(-2), Vec3::Constant(2)}, 10);
  const core::TriMesh before = ExtractMesh(map, {});
  mapping::BlockMask all;
  for (uint64_t& bits : all.bits) bits = ~uint64_t{0};
  for (const auto* chunk : map.Chunks()) {
    map.CollapseEqual(map.Find(chunk->key), all, 0);
    map.Propagate(map.Find(chunk->key), all);
  }
  EXPECT_GT(map.Count().uniform_known, 50u);
  const core::TriMesh after = ExtractMesh(map, {});
  EXPECT_EQ(after.triangles, before.triangles);
  EXPECT_EQ(after.vertices, before.vertices);
}

TEST(MeshOfField, SurfaceRunsOnFromFineToCoarseBlocks) {
  const tests::HalfSpace plane(Vec3(0, 0, 0.1), Vec3(0.2, -0.3, 1.0));
  TsdfOctree map = TsdfOf(plane, {Vec3::Constant(-2), Vec3::Constant(2)});
  for (const auto* c : map.Chunks()) {
    auto* chunk = map.Find(c->key);
    mapping::BlockMask coarse;
    for (int block = 0; block < mapping::kChunkBlocks; ++block) {
      const mapping::NodeKey at = mapping::BlockOffset(block);
      if (!chunk->fine.Test(block) || (at.x + at.y) % 2 == 0) continue;  // a chequerboard of scales
      map.MakeUniform(chunk, block, TsdfField::Unknown(), 0);
      auto& leaf = map.MakeCoarse(chunk, block, 0);
      for (int i = 0; i < 64; ++i) {
        const mapping::NodeKey voxel = {64 * c->key.x + 8 * at.x + 2 * (i & 3),
                                        64 * c->key.y + 8 * at.y + 2 * (i >> 2 & 3),
                                        64 * c->key.z + 8 * at.z + 2 * (i >> 4)};
        const Vec3 center = map.CenterOf(voxel) + Vec3::Constant(0.5 * kResolution);
        leaf.Set(i, tests::TsdfAt(plane.Distance(center), 4 * kResolution, kResolution));
      }
      coarse.Set(block);
    }
    map.Propagate(chunk, coarse);
  }
  const core::TriMesh mesh = ExtractMesh(map, {});
  EXPECT_TRUE(tests::FindFaults(mesh, map).None());
  const tests::MeshError error = ErrorOf(mesh, plane);
  EXPECT_LT(error.mean_m, 0.1 * kResolution);
  EXPECT_LT(error.worst_m, 1.0 * kResolution);
}

}  // namespace
}  // namespace atlas
