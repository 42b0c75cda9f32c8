// What fusion makes of two submaps' evidence, voxel by voxel and as a surface.
#include "mapping/atlas/submap_fusion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "core/rng.h"
#include "mapping/integrator/integrator.h"
#include "mapping/meshing/marching_cubes.h"
#include "mapping/octree/queries.h"
#include "tests/support/room_sweep.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Pose;
using core::Vec3;

constexpr double kResolutionM = 0.05;

std::map<std::array<int, 3>, int8_t> VoxelsOf(const OccupancyOctree& tree) {
  std::map<std::array<int, 3>, int8_t> voxels;
  ForEachCell(tree, [&](const NodeKey& key, int level, int8_t value) {
    const int side = 1 << level;
    for (int i = 0; i < side * side * side; ++i)
      voxels[{side * key.x + i % side, side * key.y + i / side % side, side * key.z + i / side / side}] =
          value;
  });
  return voxels;
}

OctreeContents Nothing() {
  return {OccupancyOctree(kResolutionM), {}};
}

/// The room as a robot saw it whose submap lies at T_room_submap.
OctreeContents RoomSubmap(const Pose& T_room_submap, double noise = 0.0) {
  const PlacedSpins room = RoomSweep(6, noise);
  OctreeContents contents = Nothing();
  const auto integrator = MakeRayIntegrator<OccupancyField>({});
  for (const core::SpinEvent& spin : room.spins)
    integrator->Integrate(spin, T_room_submap.inverse(), &contents.tree);
  return contents;
}

/// Mean distance of a mesh's vertices, posed by T_room_submap, to the room's faces.
double SurfaceError(const OctreeContents& contents, const Pose& T_room_submap) {
  const core::TriMesh mesh = ExtractMesh(contents.tree, {});
  const core::Box3 room{Vec3(-2, -2, 0), Vec3(2, 2, 2.4)};
  double sum = 0.0;
  for (const core::Vec3f& v : mesh.vertices) {
    const Vec3 p = T_room_submap * v.cast<double>();
    const Vec3 to_low = (p - room.min).cwiseAbs(), to_high = (p - room.max).cwiseAbs();
    sum += std::min(to_low.minCoeff(), to_high.minCoeff());
  }
  EXPECT_GT(mesh.vertices.size(), 1000u);
  return sum / static_cast<double>(mesh.vertices.size());
}

TEST(FusedValue, AddsLogOddsWithinTheClamps) {
  for (int a = -40; a <= 71; ++a) {
    for (int b = -40; b <= 71; ++b) {
      const auto x = static_cast<int8_t>(a), y = static_cast<int8_t>(b);
      const int8_t fused = FusedValue(x, y);
      if (a == 0 || b == 0) {
        EXPECT_EQ(fused, a == 0 ? b : a);
        continue;
      }
      ASSERT_TRUE(OccupancyField::Known(fused));
      const double sum = std::clamp(OccupancyField::LogOdds(x) + OccupancyField::LogOdds(y), -2.0, 3.55);
      EXPECT_NEAR(OccupancyField::LogOdds(fused), sum, 0.21) << a << " " << b;  // a step
      EXPECT_EQ(fused, FusedValue(y, x)) << a << " " << b;
    }
  }
}

TEST(FuseInto, WhereLatticesAgreeEachVoxelMovesAndAddsUp) {
  // A quarter turn and whole voxels: every voxel falls on one.
  Pose T = core::PoseFromXyzYaw(kResolutionM * Vec3(5.0, -3.0, 2.0), 0.5 * core::kPi);
  T.linear() = T.linear().array().round();
  OctreeContents from = Nothing(), to = Nothing();
  core::Rng rng(5);
  std::map<std::array<int, 3>, int8_t> expected;
  const auto random_value = [&] {
    return static_cast<int8_t>(-4 * static_cast<int>(rng.Uniform(1.0, 11.0)));
  };
  for (int i = 0; i < 4000; ++i) {
    const auto at = [&] { return static_cast<int>(std::floor(rng.Uniform(-20.0, 20.0))); };
    const std::array<int, 3> a = {at(), at(), at()}, b = {at(), at(), at()};
    to.tree.Set({a[0], a[1], a[2]}, random_value());
    from.tree.Set({b[0], b[1], b[2]}, random_value());
  }
  BlockMask all;
  all.bits.fill(~uint64_t{0});
  for (OctreeContents* c : {&from, &to}) {
    for (const auto* chunk : c->tree.Chunks()) c->tree.Propagate(c->tree.Find(chunk->key), all);
  }
  expected = VoxelsOf(to.tree);
  for (const auto& [voxel, value] : VoxelsOf(from.tree)) {
    const std::array<int, 3> moved = {-voxel[1] - 1 + 5, voxel[0] - 3, voxel[2] + 2};
    int8_t& sum = expected[moved];
    sum = static_cast<int8_t>(std::max(sum + value, -40));
  }
  FuseInto(from, T, FusionRule::kAdd, &to);
  EXPECT_TRUE(VoxelsOf(to.tree) == expected);
}

TEST(FuseInto, NothingOfASubmapIsLostHoweverItLies) {
  const OctreeContents from = RoomSubmap(Pose::Identity());
  const Pose T = core::MakePose(core::RotationFromYawPitchRoll(0.6, 0.1, -0.15), Vec3(0.33, -0.21, 0.07));
  OctreeContents to = Nothing();
  FuseInto(from, T, FusionRule::kAdd, &to);
  size_t held = 0, lost = 0;
  for (const auto& [voxel, value] : VoxelsOf(from.tree)) {
    if (value < 20) continue;
    ++held;
    // A voxel may fall between the centres of others, never far from one that asked for it.
    const Vec3 p = T * from.tree.CenterOf({voxel[0], voxel[1], voxel[2]});
    const NodeKey key = to.tree.KeyAt(p);
    bool found = false;
    for (int i = 0; i < 27; ++i)
      found = found || to.tree.At(NodeKey{key.x + i % 3 - 1, key.y + i / 3 % 3 - 1, key.z + i / 9 - 1}) > 0;
    lost += !found;
  }
  EXPECT_GT(held, 1500u);
  EXPECT_EQ(lost, 0u);
}

TEST(FuseInto, SurfacesStayAsSharpAsTheyWere) {
  const Pose T_room_b =
      core::MakePose(core::RotationFromYawPitchRoll(0.6, 0.05, -0.04), Vec3(0.33, -0.21, 0.07));
  const OctreeContents b = RoomSubmap(T_room_b, 0.005);
  const double before = SurfaceError(b, T_room_b);
  OctreeContents alone = Nothing();
  FuseInto(b, T_room_b, FusionRule::kAdd, &alone);
  const double resampled = SurfaceError(alone, Pose::Identity());
  OctreeContents both = RoomSubmap(Pose::Identity(), 0.005);
  FuseInto(b, T_room_b, FusionRule::kAdd, &both);
  const double fused = SurfaceError(both, Pose::Identity());
  OctreeContents direct = RoomSubmap(Pose::Identity(), 0.005);
  const auto integrator = MakeRayIntegrator<OccupancyField>({});
  for (const core::SpinEvent& spin : RoomSweep(6, 0.005).spins)
    integrator->Integrate(spin, Pose::Identity(), &direct.tree);
  std::printf("scans into one submap: %.2f mm\n", 1e3 * SurfaceError(direct, Pose::Identity()));
  std::printf("mean error of the mesh: %.2f mm, resampled %.2f mm, fused with its like %.2f mm\n",
              1e3 * before, 1e3 * resampled, 1e3 * fused);
  EXPECT_LT(resampled, before + 0.1 * kResolutionM);
  EXPECT_LT(fused, before + 0.05 * kResolutionM);
}

TEST(FuseInto, FreeSpaceStaysCoarse) {
  const OctreeContents from = RoomSubmap(Pose::Identity());
  OctreeContents to = RoomSubmap(Pose::Identity());
  const size_t alone = to.tree.Bytes();
  FuseInto(from, core::PoseFromXyzYaw(Vec3(0.01, 0.02, 0.0), 0.1), FusionRule::kAdd, &to);
  EXPECT_LT(to.tree.Bytes(), 2 * alone);
}

TEST(FuseInto, MarksBehindSurfacesMoveWithTheirVoxels) {
  OctreeContents from = Nothing(), to = Nothing();
  from.behind.emplace(kResolutionM, 0.3);
  to.behind.emplace(kResolutionM, 0.3);
  UndistortedSpin spin;
  spin.hits.push_back({.origin_map = core::Vec3f(0.025f, 0.025f, 0.025f),
                       .direction_map = core::Vec3f::UnitX(),
                       .range_m = 1.0f});
  from.behind->Mark(spin, 10.0);
  from.tree.Set({0, 0, 0}, -8);
  to.tree.Set({0, 0, 0}, -8);
  FuseInto(from, core::PoseFromXyzYaw(kResolutionM * Vec3(0.0, 40.0, 0.0), 0.0), FusionRule::kAdd, &to);
  const BehindSurface::Block* marks = to.behind->Find({21, 40, 0});
  ASSERT_NE(marks, nullptr);
  EXPECT_GT((*marks)[static_cast<size_t>(VoxelIndex(21, 40, 0))], 0);
}

}  // namespace
}  // namespace atlas::tests
