// The vectorised tests of cubes and cells against plain double arithmetic over the same image.
#include <gtest/gtest.h>

#include "mapping/integrator/free_space/scan_memory.h"
#include "mapping/integrator/simd_target.h"
#include "mapping/integrator/surface/hit_scatter.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

/// Ground, walls 20 to 40 m away, a tower and poles, seen by 64 beams.
tests::AnalyticWorld Yard() {
  tests::AnalyticWorld world;
  world.AddPlane({0.02, 0.01, 1}, -1.31);
  world.AddPlane({1, 0.2, 0}, 37.3);
  world.AddPlane({-0.1, 1, 0}, 22.1);
  world.AddBox({{-14.2, -12.1, -3.0}, {-9.7, -4.4, 2.2}});
  world.AddPillar(6.3, -5.1, 0.11, -2.0, 4.0);
  world.AddPillar(12.4, 7.7, 0.4, -2.0, 9.0);
  return world;
}

class FillKernels : public ::testing::Test {
 protected:
  static constexpr double kResolution = 0.13;
  /// First order is good to this, in voxels; rounding comes on top.
  static constexpr double kSlackVoxels = 0.11, kSlackRows = 0.06;

  FillKernels() {
    const core::Pose at = core::MakePose(core::RotationFromYawPitchRoll(0.4, 0.03, -0.05), {0.3, -0.2, 0.1});
    const core::SpinEvent spin = tests::SpinThrough(Yard(), lidar_, 0.0, tests::StandingAt(at));
    options_.resolution_m = static_cast<float>(kResolution);
    tables_.pierce_voxels = 0.4f;
    ColumnPoses poses;
    PosesOfScan(spin, true, &poses);
    {
      const MemoryLoan loan(spin.scan.size(), &surface_, &tables_, &rays_, &bins_);
      ProjectScan({spin.scan, poses, options_, grid_}, &rays_);
      BinRays(image_, rays_, &bins_);
      MatchCells(rays_, options_, &bins_, &image_);
    }
    FindPlanes(at.linear(), options_, image_, {&surface_, &tables_});
    BuildTables(options_, surface_, &tables_);
    hits_.Place(image_, at, kResolution, &frame_);
  }

  /// Cells from a cell's middle to its ray: columns (shift 0) or rows (16).
  double OffsetOf(size_t cell, int shift) const {
    return static_cast<int16_t>(static_cast<uint32_t>(image_.offset[cell]) >> shift) / RangeImage::kPerCell;
  }
  struct Projected {
    double u, v, distance;
    bool inside;  ///< within the rows
    int row, column;
  };
  Projected Project(double x, double y, double z) const {
    double p[3];
    for (int c = 0; c < 3; ++c) {
      p[c] = (x - frame_.sensor[0]) * frame_.axis[0][c] + (y - frame_.sensor[1]) * frame_.axis[1][c] +
             (z - frame_.sensor[2]) * frame_.axis[2][c];
    }
    Projected out;
    out.distance = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    double turn = (std::atan2(p[1], p[0]) - grid_.phase_rad) / grid_.column_pitch_rad;
    turn -= std::floor(turn / grid_.columns) * grid_.columns;
    out.u = turn;
    const double elevation = std::asin(p[2] / out.distance);
    const auto& rows = grid_.elevation_rad;
    size_t k = 0;
    while (k + 2 < rows.size() && rows[k + 1] > elevation) ++k;
    out.v = static_cast<double>(k) + (rows[k] - elevation) / (rows[k] - rows[k + 1]);
    out.inside = out.v >= -0.5 && out.v < grid_.rows - 0.5;
    out.row = std::clamp(static_cast<int>(std::floor(out.v + 0.5)), 0, grid_.rows - 1);
    out.column = static_cast<int>(std::floor(out.u + 0.5)) % grid_.columns;
    return out;
  }
  size_t Cell(int row, int column) const {
    const int wrapped = (column % grid_.columns + grid_.columns) % grid_.columns;
    return static_cast<size_t>(row) * static_cast<size_t>(grid_.columns) + static_cast<size_t>(wrapped);
  }
  double Own(int row, int column) const {
    const int wrapped = (column % grid_.columns + grid_.columns) % grid_.columns;
    return tables_
        .own[0][static_cast<size_t>(row) * static_cast<size_t>(tables_.pitch) + static_cast<size_t>(wrapped)];
  }
  /// The own beam keeps twice the support away, the ones around it once.
  double Veto(int row, int column) const {
    const size_t i = Cell(row, column);
    const double own = Own(row, column);
    if (image_.range[i] <= 0.0f) return own;
    const Vec3 normal(surface_.nx[i], surface_.ny[i], surface_.nz[i]),
        end(image_.x[i], image_.y[i], image_.z[i]);
    const double inverse_cos = std::min(end.norm() / std::abs(normal.dot(end)), 60.0);
    double support = 0.0;
    for (const auto& axis : frame_.axis)
      support += 0.5 * std::abs(normal.dot(Vec3(axis[0], axis[1], axis[2])));
    return own + support * (inverse_cos - 1.0);
  }
  double LeastVeto(int row0, int row1, int column0, int column1) const {
    double least = 1e9;
    for (int r = std::max(row0, 0); r <= std::min(row1, grid_.rows - 1); ++r) {
      for (int c = column0; c <= column1; ++c) least = std::min(least, Veto(r, c));
    }
    return least;
  }
  /// Metres from a point to the ray of the cell that it falls into.
  double FromOwnRay(const Projected& p) const {
    const size_t i = Cell(p.row, p.column);
    const double du = std::remainder(p.u - p.column - OffsetOf(i, 0), grid_.columns);
    const double eu = du * grid_.column_pitch_rad * grid_.cos_elevation[static_cast<size_t>(p.row)];
    const double ev = (p.v - p.row - OffsetOf(i, 16)) * grid_.row_pitch_rad[static_cast<size_t>(p.row)];
    return p.distance * std::hypot(eu, ev);
  }
  /// Beams whose middles lie about as near as the one that it falls to: either may be asked.
  bool BetweenCells(const Projected& p) const {
    const double column_voxel = kResolution / (p.distance * grid_.column_pitch_rad);
    const double row_voxel = kResolution / (p.distance * grid_.mean_row_pitch_rad);
    const auto near_half = [](double x, double slack) {
      return std::abs(x - std::floor(x) - 0.5) < slack || std::abs(x - std::round(x)) < slack;
    };
    return near_half(p.u, kSlackVoxels * column_voxel * 1.2) ||
           near_half(p.v, kSlackVoxels * row_voxel + kSlackRows);
  }

  NodeKey RandomCorner(core::Rng* rng, int side) const {
    const auto along = [&](int a) {
      const int blocks = frame_.chunks[static_cast<size_t>(a)] * kChunkSide / side;
      return side * static_cast<int>(rng->Uniform(0.0, blocks));
    };
    return {along(0), along(1), along(2)};
  }

  core::LidarModel lidar_ = core::FindLidarModel("os1_64");
  BeamGrid grid_ = MakeBeamGrid(lidar_);
  ImageOptions options_;
  RayBundle rays_;
  RayBins bins_;
  RangeImage image_{grid_};
  SurfaceImage surface_{image_};
  FreeSpaceTables tables_{image_};
  ScanFrame frame_;
  HitScatter hits_;
};

TEST_F(FillKernels, FirstOrderHoldsToATenthOfAVoxel) {
  core::Rng rng(3);
  int smooth = 0;
  for (int k = 0; k < 4000; ++k) {
    const NodeKey corner = RandomCorner(&rng, 8);
    CubeSlopes s;
    OctantTests tests;
    const NodeKey corners[2] = {corner, corner};
    TestOctants(tables_, frame_, corners, &tests);
    for (size_t octant = 0; octant < 8; ++octant) {
      if ((tests.cubes.smooth >> octant & 1) == 0) continue;
      s = tests.slopes;
      ++smooth;
      const double middle[3] = {corner.x + (octant & 1 ? 6.0 : 2.0), corner.y + (octant & 2 ? 6.0 : 2.0),
                                corner.z + (octant & 4 ? 6.0 : 2.0)};
      for (int corner_of = 0; corner_of < 8; ++corner_of) {
        const double d[3] = {corner_of & 1 ? 1.5 : -1.5, corner_of & 2 ? 1.5 : -1.5,
                             corner_of & 4 ? 1.5 : -1.5};
        const Projected p = Project(middle[0] + d[0], middle[1] + d[1], middle[2] + d[2]);
        double u = s.u[octant], v = s.v[octant], distance = s.distance[octant];
        for (size_t a = 0; a < 3; ++a) {
          u += d[a] * s.du[a][octant];
          v += d[a] * s.dv[a][octant];
          distance += d[a] * s.ddistance[a][octant];
        }
        const double flat = s.metres_per_column[octant] / grid_.column_pitch_rad;
        EXPECT_LT(std::abs(std::remainder(u - p.u, grid_.columns)) * grid_.column_pitch_rad * flat,
                  kSlackVoxels * kResolution);
        EXPECT_LT(std::abs(distance - p.distance), kSlackVoxels * kResolution);
        EXPECT_LT(std::abs(v - p.v),
                  kSlackRows + kSlackVoxels * kResolution / (p.distance * grid_.mean_row_pitch_rad));
      }
    }
  }
  EXPECT_GT(smooth, 500);
}

TEST_F(FillKernels, CubesSayNothingThatTheirVoxelsContradict) {
  core::Rng rng(4);
  int full = 0, gone = 0;
  for (int k = 0; k < 1500; ++k) {
    const int side = k % 2 == 0 ? 8 : 4;
    NodeKey corner[16];
    float x[16], y[16], z[16];
    for (int i = 0; i < 16; ++i) {
      corner[i] = RandomCorner(&rng, side);
      x[i] = static_cast<float>(corner[i].x) + 0.5f * static_cast<float>(side);
      y[i] = static_cast<float>(corner[i].y) + 0.5f * static_cast<float>(side);
      z[i] = static_cast<float>(corner[i].z) + 0.5f * static_cast<float>(side);
    }
    const CubeTests tests = TestBoxes(tables_, frame_, x, y, z, 0.5f * static_cast<float>(side));
    EXPECT_EQ(tests.full & tests.mixed, 0u);
    for (int i = 0; i < 16; ++i) {
      const bool is_full = tests.full >> i & 1, is_gone = !is_full && (tests.mixed >> i & 1) == 0;
      full += is_full;
      gone += is_gone;
      if (!is_full && !is_gone) continue;
      for (int n = 0; n < side * side * side; n += 3) {
        const Projected p = Project(corner[i].x + n % side + 0.5, corner[i].y + n / side % side + 0.5,
                                    corner[i].z + n / (side * side) + 0.5);
        const bool in_front = p.inside && p.distance < Own(p.row, p.column);
        if (in_front == is_full) continue;
        // Only rounding may tell them apart: of the range, or of which beam is nearest.
        const bool close = std::abs(p.distance - Own(p.row, p.column)) < 2e-3 ||
                           std::abs(p.u - std::floor(p.u) - 0.5) < 2e-3 ||
                           std::abs(p.v - std::floor(p.v) - 0.5) < 2e-3;
        EXPECT_TRUE(close) << "side " << side << (is_full ? " full" : " gone") << " at u " << p.u << " v "
                           << p.v << " distance " << p.distance << " own " << Own(p.row, p.column);
      }
    }
  }
  EXPECT_GT(full, 1000);
  EXPECT_GT(gone, 1000);
}

TEST_F(FillKernels, VoxelsAreFreeWherePlainArithmeticSaysSo) {
  core::Rng rng(5);
  int judged = 0, free_ones = 0, smooth = 0;
  for (int k = 0; k < 24000; ++k) {
    const NodeKey corner = RandomCorner(&rng, 8), corners[2] = {corner, corner};
    OctantTests tests;
    TestOctants(tables_, frame_, corners, &tests);
    const uint32_t mixed = tests.cubes.mixed & 0xff;
    if (mixed == 0) continue;
    smooth += __builtin_popcount(mixed & tests.cubes.smooth);
    VoxelBits free{};
    TestVoxels(tables_, frame_, corner, tests, 0, mixed, &free);
    for (int n = 0; n < kBlockVoxels; ++n) {
      const int vx = n & 7, vy = n >> 3 & 7, vz = n >> 6;
      if ((mixed >> ((vx >> 2) | (vy >> 2) << 1 | (vz >> 2) << 2) & 1) == 0) continue;
      const Projected p = Project(corner.x + vx + 0.5, corner.y + vy + 0.5, corner.z + vz + 0.5);
      if (p.distance < 1.0 || BetweenCells(p)) continue;
      const bool is_free = free.layer[static_cast<size_t>(vz)] >> (n & 63) & 1;
      const double slack = kSlackVoxels * kResolution;
      const int row = static_cast<int>(std::floor(p.v)), column = static_cast<int>(std::floor(p.u));
      const double voxel_columns = kResolution / (p.distance * grid_.column_pitch_rad),
                   voxel_rows = kResolution / (p.distance * grid_.mean_row_pitch_rad);
      // What must be free: far in front of every beam that the widest window could ask.
      const int wide = static_cast<int>(2.0 * voxel_columns) + 2,
                tall = static_cast<int>(2.0 * voxel_rows) + 2;
      const bool in_front = p.inside && p.distance + slack < Own(p.row, p.column);
      const bool surely = in_front && p.distance + slack < LeastVeto(row - tall, row + 1 + tall,
                                                                     column - wide, column + 1 + wide);
      // What must not: behind its own beam, or behind one of the four around it and off its own ray.
      const bool behind = !p.inside || p.distance - slack > Own(p.row, p.column);
      const bool vetoed = p.distance - slack > LeastVeto(row, row + 1, column, column + 1);
      const bool pierced = FromOwnRay(p) < (tables_.pierce_voxels + 2.0 * kSlackVoxels) * kResolution;
      if (surely) {
        EXPECT_TRUE(is_free) << "u " << p.u << " v " << p.v << " distance " << p.distance;
      } else if (behind || (vetoed && !pierced)) {
        EXPECT_FALSE(is_free) << "u " << p.u << " v " << p.v << " distance " << p.distance;
      } else {
        continue;
      }
      ++judged;
      free_ones += is_free;
    }
  }
  EXPECT_GT(judged, 100000);
  EXPECT_GT(free_ones, 20000);
  EXPECT_GT(smooth, 1000);
}

TEST_F(FillKernels, WindowsBelowTheGridAskNothing) {
  // Slopes of an octant just below the last row, in a corner of the images.
  OctantTests tests{};
  tests.cubes.smooth = tests.cubes.mixed = 1;
  CubeSlopes& s = tests.slopes;
  s.u[0] = static_cast<float>(grid_.columns) - 2.0f;
  s.first_column[0] = grid_.columns - 8;
  for (int below = 0; below < 3; ++below) {
    s.v[0] = static_cast<float>(grid_.rows + below);
    s.first_row[0] = grid_.rows + below;
    for (int window = 0; window < CubeSlopes::kWindows; ++window) {
      s.window[0] = window;
      VoxelBits free{};
      TestVoxels(tables_, frame_, {0, 0, 0}, tests, 0, 1, &free);
      for (const uint64_t layer : free.layer) EXPECT_EQ(layer, 0u);
    }
  }
}

TEST(FillKernelsRepeat, FarScenesGiveTheSameMapOnEverySimdTarget) {
  const core::LidarModel lidar = core::FindLidarModel("os1_64");
  core::Rng noise(6);
  const auto spins = tests::WalkThrough(Yard(), lidar, 2, &noise);
  const auto digest = [&] { return tests::DigestOf(tests::MapOf<OccupancyField>(spins, lidar, {}, 0.13)); };
  LimitSimd("scalar");
  const auto expected = digest();
  EXPECT_GT(expected.size(), 1000000u);
  for (const std::string& target : SimdTargets()) {
    LimitSimd(target);
    EXPECT_TRUE(digest() == expected) << target;
  }
  LimitSimd("");
}

}  // namespace
}  // namespace atlas::mapping
