// Meshes hang together whatever the octree holds: random values at random scales, chunk borders, threads.

#include <gtest/gtest.h>

#include "core/rng.h"
#include "mapping/meshing/cube_table.h"
#include "mapping/meshing/marching_cubes.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/field_of_shape.h"
#include "tests/support/mesh_cracks.h"

namespace atlas {
namespace {

using core::Vec3;
using mapping::NodeKey;
using mapping::OccupancyField;
using mapping::OccupancyOctree;
using mapping::TsdfField;
using mapping::TsdfOctree;

OccupancyField::Value RandomValue(OccupancyField, core::Rng* rng) {
  return static_cast<int8_t>(rng->UniformInt(111) + OccupancyField::kMin);
}
TsdfField::Value RandomValue(TsdfField, core::Rng* rng) {
  return {static_cast<int16_t>(rng->UniformInt(8001) - 4000), static_cast<uint8_t>(rng->UniformInt(20))};
}

/// Blocks around the corner of eight chunks: a third uniform, coarse and fine each.
template <typename Field>
mapping::Octree<Field> RandomOctree(uint64_t seed) {
  mapping::Octree<Field> map(0.1);
  core::Rng rng(seed);
  for (int i = 0; i < 6 * 6 * 6; ++i) {
    const NodeKey block = {i % 6 - 3, i / 6 % 6 - 3, i / 36 - 3};
    auto* chunk = map.FindOrCreate(block.Up(3));
    const int b = mapping::BlockIndex(block.x, block.y, block.z);
    map.MakeUniform(chunk, b, RandomValue(Field{}, &rng), 0);
    const int kind = rng.UniformInt(3);
    if (kind == 1) {
      auto& leaf = map.MakeCoarse(chunk, b, 0);
      for (int k = 0; k < 64; ++k) leaf.Set(k, RandomValue(Field{}, &rng));
    } else if (kind == 2) {
      auto& leaf = map.MakeFine(chunk, b, 0);
      for (int k = 0; k < 512; ++k) leaf.Set(k, RandomValue(Field{}, &rng));
    }
    chunk->dirty.Set(b);
  }
  tests::Refresh(&map);
  return map;
}

template <typename Field>
void ExpectWhole(const mapping::Octree<Field>& map) {
  const core::TriMesh mesh = ExtractMesh(map, {.undo_shift = false});
  ASSERT_GT(mesh.triangles.size(), 1000u);
  const tests::MeshFaults faults = tests::FindFaults(mesh, map);
  EXPECT_EQ(faults.cracks, 0u);
  EXPECT_EQ(faults.crowded, 0u);
  EXPECT_EQ(faults.flipped, 0u);
  EXPECT_EQ(faults.degenerate, 0u);
  EXPECT_EQ(faults.duplicate, 0u);
  EXPECT_EQ(faults.unused, 0u);
  EXPECT_GT(faults.border_edges, 0u);
}

/// Every edge between a known inside and a known outside voxel, in a cell that is known, bears one vertex.
template <typename Field>
size_t CountCrossings(const mapping::Octree<Field>& map, int reach) {
  size_t count = 0;
  const auto cell_known = [&](const NodeKey& low) {
    for (int c = 0; c < 8; ++c) {
      if (!Field::Known(map.At(NodeKey{low.x + (c & 1), low.y + (c >> 1 & 1), low.z + (c >> 2)})))
        return false;
    }
    return true;
  };
  for (int z = -reach; z < reach; ++z) {
    for (int y = -reach; y < reach; ++y) {
      for (int x = -reach; x < reach; ++x) {
        for (int axis = 0; axis < 3; ++axis) {
          const std::array<int, 3> step = {axis == 0, axis == 1, axis == 2};
          const auto a = map.At(NodeKey{x, y, z}), b = map.At(NodeKey{x + step[0], y + step[1], z + step[2]});
          if (!Field::Known(a) || !Field::Known(b) || Field::Occupied(a) == Field::Occupied(b)) continue;
          bool seen = false;
          for (int i = 0; i < 4; ++i) {
            std::array<int, 3> low = {x, y, z};
            low[static_cast<size_t>((axis + 1) % 3)] -= i & 1;
            low[static_cast<size_t>((axis + 2) % 3)] -= i >> 1;
            seen = seen || cell_known({low[0], low[1], low[2]});
          }
          count += seen;
        }
      }
    }
  }
  return count;
}

TEST(MeshTopology, RandomOccupancyAtMixedScalesHasNoCracks) {
  for (uint64_t seed = 1; seed <= 3; ++seed) ExpectWhole(RandomOctree<OccupancyField>(seed));
}
TEST(MeshTopology, RandomDistancesAtMixedScalesHaveNoCracks) {
  for (uint64_t seed = 1; seed <= 3; ++seed) ExpectWhole(RandomOctree<TsdfField>(seed));
}

TEST(MeshTopology, EveryObservedSignChangeBearsOneVertex) {
  const auto occupancy = RandomOctree<OccupancyField>(7);
  EXPECT_EQ(ExtractMesh(occupancy, {}).vertices.size(), CountCrossings(occupancy, 26));
  const auto tsdf = RandomOctree<TsdfField>(8);
  EXPECT_EQ(ExtractMesh(tsdf, {}).vertices.size(), CountCrossings(tsdf, 26));
}

TEST(MeshTopology, ThreadsDoNotChangeAByte) {
  const auto map = RandomOctree<OccupancyField>(9);
  const core::TriMesh one = ExtractMesh(map, {.threads = 1});
  for (const int threads : {2, 4}) {
    const core::TriMesh more = ExtractMesh(map, {.threads = threads});
    ASSERT_EQ(more.triangles, one.triangles);
    ASSERT_EQ(more.vertices, one.vertices);
  }
}

TEST(MeshTopology, SmallPiecesAreLeftOut) {
  OccupancyOctree map(0.1);
  tests::FillOctree<OccupancyField>(
      {Vec3::Constant(-2), Vec3::Constant(2)},
      [](const Vec3& p) -> OccupancyField::Value {
        const bool ball = (p - Vec3(0.7, 0.7, 0.7)).norm() < 0.8;
        const bool speck = (p + Vec3::Constant(1.05)).norm() < 0.05;
        return ball || speck ? 40 : -40;
      },
      &map);
  const core::TriMesh all = ExtractMesh(map, {});
  const core::TriMesh large = ExtractMesh(map, {.min_component_m2 = 0.5});
  EXPECT_EQ(all.triangles.size() - large.triangles.size(), 8u);  // the octahedron about one voxel
  EXPECT_EQ(all.vertices.size() - large.vertices.size(), 6u);
  EXPECT_TRUE(large.Bounds().min.minCoeff() > -0.3);
  EXPECT_TRUE(ExtractMesh(map, {.min_component_m2 = 100.0}).vertices.empty());
}

TEST(CubeTable, EveryCaseClosesAgainstItsComplementOnFaces) {
  // A triangle side between two edges of one face is the surface's line there; its mirror is drawn by the
  // cube beyond the face, which sees the same corners. Interior sides cancel within the cube.
  const mapping::CubeTable table;
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::map<std::pair<int, int>, int> sides;
    const mapping::CubeCase& cube = table.Case(inside);
    for (size_t i = 0; i < static_cast<size_t>(cube.count); ++i) {
      for (size_t k = 0; k < 3; ++k) ++sides[{cube.triangle[i][k], cube.triangle[i][(k + 1) % 3]}];
    }
    for (const auto& [side, count] : sides) {
      ASSERT_EQ(count, 1);
      const mapping::CubeEdge &a = table.Edge(static_cast<size_t>(side.first)),
                              &b = table.Edge(static_cast<size_t>(side.second));
      bool on_face = false;
      for (size_t axis = 0; axis < 3; ++axis) {
        on_face = on_face || (a.axis != static_cast<int>(axis) && b.axis != static_cast<int>(axis) &&
                              a.corner[axis] == b.corner[axis]);
      }
      EXPECT_EQ(sides.count({side.second, side.first}), on_face ? 0u : 1u) << "case " << inside;
    }
  }
}

TEST(MeshTopology, ProgressCountsEveryChunkOnce) {
  const auto map = RandomOctree<TsdfField>(21);
  std::vector<size_t> told;
  mapping::MeshOptions options;
  options.threads = 4;
  options.progress = [&](size_t done, size_t chunks) {
    EXPECT_EQ(chunks, 8u);
    told.push_back(done);
  };
  ExtractMesh(map, options);
  EXPECT_EQ(told, (std::vector<size_t>{1, 2, 3, 4, 5, 6, 7, 8}));
}

}  // namespace
}  // namespace atlas
