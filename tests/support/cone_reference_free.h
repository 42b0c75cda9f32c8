// Scalar reference of the cone integrator, stage 3: which voxels a scan sees as free.
//
//               veto window: 2 x 2 cells about the voxel's place, more where a voxel is wider than a cell
//              +-----+-----+
//              |  o  |  o  |     o: a cell's middle; * the voxel's centre. Its own cell is the one that holds
//              |    *|     |     it. Free: the own beam returned behind it, and no beam of the window in
//              +-----+-----+     front of it, each less the voxel's support off that beam's plane.
//              |  o  |  o  |
//              +-----+-----+     Or: the own beam pierces the voxel, where beams are less than two voxels
//                                apart (what beams around met then does not veto).
//
// Cubes wholly in front of every beam that can touch them are free as a whole. Space is decided in cells of
// 1, 2 or 4 voxels, no wider than beams are apart at the middle of their block (thesis 4.5.1).
#pragma once

#include <array>
#include <limits>

#include "tests/support/cone_reference_image.h"

namespace atlas::tests::cone {

/// Where a block, an octant or a voxel lies, in voxels of the map's lattice.
struct Cube {
  Vec3 middle;
  double side = 1.0;
};

/// Up to where a beam leaves room for cells of a scale, metres from the sensor.
struct Room {
  double own, veto;
};

/// What decides free space of one scan.
struct FreeSpace {
  const RangeImage* image = nullptr;
  core::Pose T_lidar_map = core::Pose::Identity();
  mapping::IntegratorParams params;
  double resolution = 0.1;
  int max_scale = 1;  ///< params.max_scale, and no wider than beams are apart at the farthest return
  std::array<std::vector<Room>, 3> room;  ///< of every cell of the image, for cells of 1, 2 and 4 voxels

  const Room& RoomAt(int row, int column, int scale) const {
    return room[scale == 4 ? 2 : static_cast<size_t>(scale - 1)][image->beams.Cell(row, column)];
  }
};

/// A point in the range image.
struct Seen {
  double u, v, distance;
};
inline Seen SeenAt(const FreeSpace& f, const Vec3& p_voxels) {
  const Vec3 p = f.T_lidar_map * (f.resolution * p_voxels);
  const double distance = std::max(p.norm(), 1e-6);
  const Beams& beams = f.image->beams;
  return {beams.ColumnOf(std::atan2(p.y(), p.x())),
          beams.RowOf(std::asin(std::clamp(p.z() / distance, -1.0, 1.0))), distance};
}

/// 3 sigma and the support of `scale` voxels off the beam's plane. The own beam keeps the support away twice,
/// since a cell that it pierces may hang below it by as much.
inline Room RoomOf(const FreeSpace& f, const Cell& cell, int scale) {
  if (cell.range <= 0.0) return {-cell.range, -cell.range};
  const Vec3 normal_map = f.T_lidar_map.linear().transpose() * cell.normal;
  const double support = scale * 0.5 * f.resolution * normal_map.lpNorm<1>(), t = cell.inverse_cos;
  const double band = 3.0 * std::max(f.params.sigma_min_m, f.params.lambda_sigma * cell.free_range);
  const double veto = cell.free_range - (support + band) * t;
  const double own = veto - support * (t - 1.0);
  return {std::max(own, 0.002), std::max(veto, 0.002)};
}

inline FreeSpace FreeSpaceOf(const RangeImage& image, const core::Pose& T_map_lidar,
                             const mapping::IntegratorParams& params, double resolution) {
  FreeSpace f{&image, T_map_lidar.inverse(), params, resolution, params.max_scale == 3 ? 2 : params.max_scale,
              {}};
  while (f.max_scale > 1 && f.max_scale * resolution > image.reach * image.beams.min_pitch) f.max_scale /= 2;
  for (size_t k = 0; k < 3; ++k) {
    for (const Cell& cell : image.cells) f.room[k].push_back(RoomOf(f, cell, 1 << k));
  }
  return f;
}

/// Rows and columns of the veto window of a block's voxels: powers of two.
struct Window {
  int rows = 2, columns = 2;
};
inline Window WindowOf(const FreeSpace& f, const Cube& block, int scale) {
  const Beams& beams = f.image->beams;
  if (scale > 1) return {};
  const double nearest =
      std::max(SeenAt(f, block.middle).distance - 0.25 * std::sqrt(3.0) * block.side * f.resolution, 0.3);
  const double cells = f.resolution / (beams.min_pitch * nearest);  // a voxel's width in the finest cells
  int level = 1;
  while (level < 6 && (1 << level) < 0.75 * cells + 1.0) ++level;
  // Where rows are farther apart than columns, as many rows fewer, and the other way round.
  const int bias = static_cast<int>(std::lround(std::log2(beams.mean_row_pitch / beams.column_pitch)));
  return {1 << std::max(1, level - std::max(bias, 0)), 1 << std::max(1, level - std::max(-bias, 0))};
}

/// The least room over the window about a place.
inline double VetoOf(const FreeSpace& f, const Seen& at, const Window& window, int scale) {
  const int top = static_cast<int>(std::floor(at.v)) + 1 - window.rows / 2;
  const int left = static_cast<int>(std::floor(at.u)) + 1 - window.columns / 2;
  double least = std::numeric_limits<double>::infinity();
  for (int row = std::max(top, 0); row < std::min(top + window.rows, f.image->beams.rows); ++row) {
    for (int column = left; column < left + window.columns; ++column) {
      least = std::min(least, f.RoomAt(row, column, scale).veto);
    }
  }
  return least;
}

/// Whether beams are at least `voxels` apart at the middle of a block.
inline bool BeamsApart(const FreeSpace& f, const Cube& block, double voxels) {
  return SeenAt(f, block.middle).distance * f.image->beams.min_pitch >= voxels * f.resolution;
}

/// How a block is decided: in cells of `scale` voxels, no wider than beams are apart (thesis 4.5.1).
struct BlockRule {
  int scale = 1;
  Window window;
  bool pierces = false;
};
inline BlockRule RuleOf(const FreeSpace& f, const Cube& block, bool by_voxel) {
  const int apart = BeamsApart(f, block, 4.0) ? 4 : BeamsApart(f, block, 2.0) ? 2 : 1;
  const int scale = by_voxel ? 1 : std::min(f.max_scale, apart);
  return {scale, WindowOf(f, block, scale), scale == 1 && apart == 1};
}

/// The cell of `rule.scale` voxels about `middle`.
inline bool CellIsFree(const FreeSpace& f, const Vec3& middle, const BlockRule& rule) {
  const Beams& beams = f.image->beams;
  const Seen at = SeenAt(f, middle);
  if (at.v < -0.5 || at.v >= beams.rows - 0.5) return false;
  const int row = static_cast<int>(std::floor(at.v + 0.5)), column = static_cast<int>(std::floor(at.u + 0.5));
  if (at.distance >= f.RoomAt(row, column, rule.scale).own) return false;
  if (at.distance < VetoOf(f, at, rule.window, rule.scale)) return true;
  const Cell& own = f.image->At(row, column);
  const double beside = (at.u - column - own.du) * beams.ColumnAngle(row) * at.distance;
  const double above = (at.v - row - own.dv) * beams.RowAngle(row) * at.distance;
  return rule.pierces && std::hypot(beside, above) < f.params.pierce_voxels * f.resolution;
}

/// The angles that a cube spans, from below: of azimuth and of elevation, about its middle; infinite about
/// the sensor's axis.
struct Span {
  double columns = 0.0, top = 0.0, bottom = 0.0, farthest = 0.0;
  bool about_axis = false;
};
inline Span SpanOf(const FreeSpace& f, const Cube& cube) {
  const Vec3 p = f.T_lidar_map * (f.resolution * cube.middle);
  const double flat = std::hypot(p.x(), p.y()), distance = p.norm(), half = 0.5 * cube.side * f.resolution;
  const double radius = std::sqrt(3.0) * half;
  Span span;
  span.about_axis = flat < 2.5 * radius;
  if (span.about_axis) return span;
  const Vec3 along = p / distance, across(-p.y() / flat, p.x() / flat, 0.0), up = along.cross(across);
  const Vec3 outward(p.x() / flat, p.y() / flat, 0.0);
  const auto extent = [&](const Vec3& d) {
    return half * (f.T_lidar_map.linear().transpose() * d).lpNorm<1>();
  };
  const double sideways = extent(across), depth = extent(along);
  const double turned = sideways / std::max(flat - extent(outward), 1e-6);
  // Points beside the middle's upright plane lie farther out than they seem.
  const double bulge = 0.5 * sideways * turned * std::abs(along.z());
  const double raised = std::asin(std::min((extent(up) + bulge) / std::max(distance - depth, 1e-6), 1.0));
  const double elevation = std::asin(along.z());
  const Beams& beams = f.image->beams;
  const auto row_of = [&](double e) { return beams.RowOf(std::asin(std::sin(e))); };
  span.columns = std::min(turned / beams.column_pitch, static_cast<double>(beams.columns));
  span.top = row_of(elevation + raised);
  span.bottom = row_of(elevation - raised);
  span.farthest = distance + depth + (radius * radius - depth * depth) / (2.0 * distance);
  return span;
}

/// Whether the whole cube lies in front of every beam that can touch it. The beams are taken by windows of
/// 2^k rows and 2^(k + s) columns, two each way; k is at most 5, and cubes that span more are not decided.
inline bool IsFull(const FreeSpace& f, const Cube& cube) {
  const Beams& beams = f.image->beams;
  const Span span = SpanOf(f, cube);
  if (span.about_axis || span.top < 0.0 || span.bottom > beams.rows - 1) return false;
  const int first_row = static_cast<int>(span.top),
            last_row = std::min(static_cast<int>(span.bottom + 1.0), beams.rows - 1);
  const double u = SeenAt(f, cube.middle).u;
  const int first_column = static_cast<int>(std::floor(u - span.columns)),
            last_column = static_cast<int>(std::floor(u + span.columns + 1.0));
  const int shift =
      std::clamp(static_cast<int>(std::ceil(std::log2(beams.mean_row_pitch / beams.column_pitch))), 0, 3);
  const int rows = last_row - first_row + 1, columns = last_column - first_column + 1;
  int k = 0;
  while (2 << k < rows || 2 << (k + shift) < columns) ++k;
  if (k > 5) return false;
  const double unit = (f.params.max_range_m + 1.0) / 65000.0;  // bounds are held in, rounded down
  for (int row = first_row; row <= std::max(last_row, first_row + (1 << k) - 1); ++row) {
    for (int i = 0; i < std::max(columns, 1 << (k + shift)); ++i) {
      const double own = f.RoomAt(std::min(row, beams.rows - 1), first_column + i, 1).own;
      if (span.farthest >= unit * std::floor(own / unit)) return false;
    }
  }
  return true;
}

}  // namespace atlas::tests::cone
